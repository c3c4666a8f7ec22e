// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/losses/joint_contrastive_loss.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "semantics/losses/matrix_products.h"

namespace freegs::semantics {
namespace {

constexpr int64_t kMemberGrain = 256;
constexpr double kMinLength = 1e-12;

struct Member {
  const float* feature = nullptr;
  float* gradient = nullptr;
  uint32_t group = 0;  // Place among the groups.
  double length = 0;
};

// Unit vectors of the groups' means, and who is whose positive.
struct Prototypes {
  RowMatrix directions;            // G x D
  std::vector<uint8_t> positives;  // G x G
  std::vector<double> shares;      // G: of one member in the loss.

  int64_t size() const { return directions.rows(); }
};

Status CheckSizes(const ContrastiveMembers& members, int dim) {
  if (dim > 0 && members.features.size() == members.groups.size() * dim &&
      members.gradients.size() == members.features.size()) {
    return Status();
  }
  return InvalidArgumentError(
      std::to_string(members.features.size()) + " feature values and " +
      std::to_string(members.gradients.size()) + " gradients for " +
      std::to_string(members.groups.size()) + " members of groups");
}

double Length(const float* feature, int dim) {
  double sum = 0;
  for (int k = 0; k < dim; ++k) {
    sum += static_cast<double>(feature[k]) * feature[k];
  }
  return std::sqrt(sum);
}

// Those of a group and with a direction, in order, with their group's number as
// it came, and their length.
std::vector<Member> CollectMembers(const ContrastiveMembers& gaussians,
                                   const ContrastiveMembers& pixels,
                                   int dim,
                                   ThreadPool& pool) {
  std::vector<Member> members;
  for (const ContrastiveMembers* side : {&gaussians, &pixels}) {
    for (size_t j = 0; j < side->groups.size(); ++j) {
      if (side->groups[j] < 0) continue;
      members.push_back({side->features.data() + j * dim,
                         side->gradients.data() + j * dim,
                         static_cast<uint32_t>(side->groups[j])});
    }
  }
  pool.ParallelFor(0,
                   static_cast<int64_t>(members.size()),
                   kMemberGrain,
                   [&](int64_t first, int64_t last, int) {
                     for (int64_t j = first; j < last; ++j) {
                       members[j].length = Length(members[j].feature, dim);
                     }
                   });
  std::erase_if(members, [](const Member& m) { return m.length < kMinLength; });
  return members;
}

// Numbers the members' groups from 0; returns how many there are.
size_t NumberGroups(std::vector<Member>* members) {
  std::vector<uint32_t> groups;
  groups.reserve(members->size());
  for (const Member& member : *members) groups.push_back(member.group);
  std::sort(groups.begin(), groups.end());
  groups.erase(std::unique(groups.begin(), groups.end()), groups.end());
  for (Member& member : *members) {
    member.group = static_cast<uint32_t>(
        std::lower_bound(groups.begin(), groups.end(), member.group) -
        groups.begin());
  }
  return groups.size();
}

// G x D sums of the members' features: their directions are the means'. Threads
// share out the channels.
std::vector<double> SumGroups(const std::vector<Member>& members,
                              size_t num_groups,
                              int dim,
                              ThreadPool& pool) {
  constexpr int64_t kChannelGrain = 16;
  std::vector<double> sums(num_groups * dim, 0.0);
  pool.ParallelFor(
      0, dim, kChannelGrain, [&](int64_t first, int64_t last, int) {
        for (const Member& member : members) {
          double* sum = sums.data() + static_cast<size_t>(member.group) * dim;
          for (int64_t k = first; k < last; ++k) sum[k] += member.feature[k];
        }
      });
  return sums;
}

// Drops groups whose mean has no direction, with their members.
Prototypes MakePrototypes(int dim,
                          double positive_cosine,
                          ThreadPool& pool,
                          std::vector<Member>* members) {
  const size_t num_groups = NumberGroups(members);
  const std::vector<double> sums = SumGroups(*members, num_groups, dim, pool);
  std::vector<double> counts(num_groups, 0.0);
  for (const Member& member : *members) ++counts[member.group];

  constexpr uint32_t kDropped = std::numeric_limits<uint32_t>::max();
  std::vector<uint32_t> places(num_groups, kDropped);
  std::vector<Eigen::VectorXd> units;
  Prototypes prototypes;
  for (size_t g = 0; g < num_groups; ++g) {
    const Eigen::Map<const Eigen::VectorXd> sum(sums.data() + g * dim, dim);
    const double length = sum.norm();
    if (length < kMinLength * counts[g]) continue;
    places[g] = static_cast<uint32_t>(units.size());
    units.push_back(sum / length);
    prototypes.shares.push_back(1 / counts[g]);
  }
  for (Member& member : *members) member.group = places[member.group];
  std::erase_if(*members, [](const Member& m) { return m.group == kDropped; });

  const size_t size = units.size();
  prototypes.directions.resize(static_cast<int64_t>(size), dim);
  prototypes.positives.resize(size * size);
  for (size_t g = 0; g < size; ++g) {
    prototypes.shares[g] /= static_cast<double>(size);
    prototypes.directions.row(static_cast<int64_t>(g)) =
        units[g].cast<float>().transpose();
    for (size_t h = 0; h < size; ++h) {
      prototypes.positives[g * size + h] =
          g == h || units[g].dot(units[h]) > positive_cosine;
    }
  }
  return prototypes;
}

// A member's loss. Turns its cosines to all groups into dl / dcosine.
class MemberLoss {
 public:
  explicit MemberLoss(const ContrastiveOptions& options) : options_(options) {}

  double Differentiate(const uint8_t* positive,
                       int64_t num_groups,
                       float* cosines) const {
    const double log_positive = LogSum(positive, 1, num_groups, cosines);
    const double log_negative = LogSum(positive, 0, num_groups, cosines);
    if (!(log_negative > -std::numeric_limits<double>::infinity())) {
      std::fill_n(cosines, num_groups, 0.0f);  // Nothing to tell it from.
      return 0;
    }
    const double d = log_negative - log_positive;
    const bool printed = options_.form == ContrastiveForm::kAsPrinted;
    // dl / dd, over tau.
    const double slope =
        (printed ? 1 : 1 / (1 + std::exp(-d))) / options_.temperature;
    for (int64_t g = 0; g < num_groups; ++g) {
      const double s = cosines[g] / options_.temperature;
      cosines[g] =
          static_cast<float>(positive[g] ? -slope * std::exp(s - log_positive)
                                         : slope * std::exp(s - log_negative));
    }
    if (printed) return d;
    return std::max(d, 0.0) + std::log1p(std::exp(-std::abs(d)));
  }

 private:
  // log sum exp(cosine / tau) over the groups of one kind; -infinity for none.
  double LogSum(const uint8_t* positive,
                uint8_t kind,
                int64_t num_groups,
                const float* cosines) const {
    double largest = -std::numeric_limits<double>::infinity();
    for (int64_t g = 0; g < num_groups; ++g) {
      if (positive[g] == kind) {
        largest = std::max<double>(largest, cosines[g]);
      }
    }
    double sum = 0;
    for (int64_t g = 0; g < num_groups; ++g) {
      if (positive[g] == kind) {
        sum += std::exp((cosines[g] - largest) / options_.temperature);
      }
    }
    return largest / options_.temperature + std::log(sum);
  }

  ContrastiveOptions options_;
};

// The sum of a block's losses, by their shares; adds to their gradients.
double AddBlock(std::span<const Member> members,
                const Prototypes& prototypes,
                const MemberLoss& member_loss,
                double weight) {
  const auto rows = static_cast<int64_t>(members.size());
  const int64_t dim = prototypes.directions.cols();
  const int64_t num_groups = prototypes.size();
  RowMatrix units(rows, dim);
  for (int64_t j = 0; j < rows; ++j) {
    for (int64_t k = 0; k < dim; ++k) {
      units(j, k) =
          static_cast<float>(members[j].feature[k] / members[j].length);
    }
  }
  RowMatrix cosines(rows, num_groups);
  cosines.noalias() = units * prototypes.directions.transpose();
  double loss = 0;
  for (int64_t j = 0; j < rows; ++j) {
    const size_t group = members[j].group;
    loss += prototypes.shares[group] *
            member_loss.Differentiate(
                prototypes.positives.data() + group * num_groups,
                num_groups,
                cosines.row(j).data());
  }
  RowMatrix slopes(rows, dim);  // dl / d unit vector.
  slopes.noalias() = cosines * prototypes.directions;
  for (int64_t j = 0; j < rows; ++j) {
    const Member& member = members[j];
    // A change along the feature does not turn it.
    const float along = slopes.row(j).dot(units.row(j));
    const double scale =
        weight * prototypes.shares[member.group] / member.length;
    for (int64_t k = 0; k < dim; ++k) {
      member.gradient[k] +=
          static_cast<float>(scale * (slopes(j, k) - along * units(j, k)));
    }
  }
  return loss;
}

}  // namespace

Status ContrastiveOptions::Check() const {
  if (!(temperature > 0 && std::isfinite(temperature))) {
    return InvalidArgumentError("the contrastive temperature must be > 0");
  }
  if (!(positive_cosine >= -1 && positive_cosine <= 1)) {
    return InvalidArgumentError(
        "the cosine above which groups are positives must be in [-1, 1]");
  }
  return Status();
}

StatusOr<double> JointContrastiveLoss(const ContrastiveOptions& options,
                                      int dim,
                                      const ContrastiveMembers& gaussians,
                                      const ContrastiveMembers& pixels,
                                      double weight,
                                      ThreadPool& pool) {
  FREEGS_RETURN_IF_ERROR(options.Check());
  FREEGS_RETURN_IF_ERROR(CheckSizes(gaussians, dim));
  FREEGS_RETURN_IF_ERROR(CheckSizes(pixels, dim));
  std::vector<Member> members = CollectMembers(gaussians, pixels, dim, pool);
  for (const Member& member : members) {
    if (!std::isfinite(member.length)) {
      return InvalidArgumentError("features to contrast are not finite");
    }
  }
  const Prototypes prototypes =
      MakePrototypes(dim, options.positive_cosine, pool, &members);

  const MemberLoss member_loss(options);
  const auto count = static_cast<int64_t>(members.size());
  std::vector<double> losses((count + kMemberGrain - 1) / kMemberGrain, 0.0);
  pool.ParallelFor(
      0, count, kMemberGrain, [&](int64_t first, int64_t last, int) {
        losses[first / kMemberGrain] =
            AddBlock(std::span(members).subspan(first, last - first),
                     prototypes,
                     member_loss,
                     weight);
      });
  double loss = 0;
  for (const double part : losses) loss += part;
  return loss;
}

}  // namespace freegs::semantics
