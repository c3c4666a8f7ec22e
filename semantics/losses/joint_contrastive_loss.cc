// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/losses/joint_contrastive_loss.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "semantics/losses/matrix_products.h"
#include "semantics/losses/matrix_products_simd.h"

namespace freegs::semantics {
namespace {

constexpr int64_t kMemberGrain = 256;
constexpr double kMinLength = 1e-12;
// Every group is compared with every other.
constexpr size_t kMaxGroups = 4096;

struct Member {
  const float* feature = nullptr;
  float* gradient = nullptr;
  uint32_t group = 0;  // Place among the groups.
  double length = 0;
};

// Unit vectors of the mean features of groups, and which groups are positives
// of each other.
struct Prototypes {
  RowMatrix directions;            // G x D
  std::vector<uint8_t> positives;  // G x G
  std::vector<double> shares;      // G: of one member in the loss.

  size_t size() const { return shares.size(); }
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

// The members that have a group and a direction, in order. `group` is the
// number that the caller gave.
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

// G x D sums of the members' features, whose directions are those of the means.
// Threads share out the channels.
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
                          size_t num_groups,
                          double positive_cosine,
                          ThreadPool& pool,
                          std::vector<Member>* members) {
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

// A member's loss l. Turns its cosines to all groups into dl / dcosine.
double DifferentiateMember(const ContrastiveOptions& options,
                           std::span<const uint8_t> positive,
                           std::span<float> cosines) {
  constexpr float kNone = -2;  // Less than any cosine.
  // The first entry is that of negatives, the second that of positives.
  float largest[2] = {kNone, kNone};
  for (size_t g = 0; g < cosines.size(); ++g) {
    largest[positive[g]] = std::max(largest[positive[g]], cosines[g]);
  }
  if (largest[0] == kNone) {  // There are no negatives.
    std::fill(cosines.begin(), cosines.end(), 0.0f);
    return 0;
  }
  const auto inv_temperature = static_cast<float>(1 / options.temperature);
  double sums[2] = {0, 0};
  for (size_t g = 0; g < cosines.size(); ++g) {
    cosines[g] =
        std::exp((cosines[g] - largest[positive[g]]) * inv_temperature);
    sums[positive[g]] += cosines[g];
  }
  const double d =
      (static_cast<double>(largest[0]) - largest[1]) / options.temperature +
      std::log(sums[0]) - std::log(sums[1]);
  const double slope = 1 / (1 + std::exp(-d));  // dl / dd
  const auto negative_factor =
      static_cast<float>(slope / options.temperature / sums[0]);
  const auto positive_factor =
      static_cast<float>(-slope / options.temperature / sums[1]);
  for (size_t g = 0; g < cosines.size(); ++g) {
    cosines[g] *= positive[g] ? positive_factor : negative_factor;
  }
  return std::max(d, 0.0) + std::log1p(std::exp(-std::abs(d)));
}

// Adds the part of a slope that turns the unit vector. The part along the
// vector only changes its length.
void AddTurn(std::span<const float> slope,
             std::span<const float> unit,
             double scale,
             float* gradient) {
  double along = 0;
  for (size_t k = 0; k < unit.size(); ++k) {
    along += static_cast<double>(slope[k]) * unit[k];
  }
  for (size_t k = 0; k < unit.size(); ++k) {
    gradient[k] += static_cast<float>(scale * (slope[k] - along * unit[k]));
  }
}

// Returns the sum of the losses of a block of members, weighted by their
// shares, and adds to their gradients.
double AddBlock(const ContrastiveOptions& options,
                std::span<const Member> members,
                const Prototypes& prototypes,
                double weight) {
  const size_t rows = members.size();
  const auto dim = static_cast<size_t>(prototypes.directions.cols());
  const size_t num_groups = prototypes.size();
  std::vector<float> units(rows * dim);
  for (size_t j = 0; j < rows; ++j) {
    for (size_t k = 0; k < dim; ++k) {
      units[j * dim + k] =
          static_cast<float>(members[j].feature[k] / members[j].length);
    }
  }
  const float* directions = prototypes.directions.data();
  std::vector<float> cosines(rows * num_groups, 0.0f);
  AddProductColumns({units.data(), dim, 1},
                    {directions, 1, dim},
                    rows,
                    dim,
                    0,
                    num_groups,
                    cosines.data(),
                    num_groups);
  double loss = 0;
  for (size_t j = 0; j < rows; ++j) {
    const size_t group = members[j].group;
    loss += prototypes.shares[group] *
            DifferentiateMember(
                options,
                std::span(prototypes.positives)
                    .subspan(group * num_groups, num_groups),
                std::span(cosines).subspan(j * num_groups, num_groups));
  }
  std::vector<float> slopes(rows * dim, 0.0f);  // dl / d unit vector.
  AddProductColumns({cosines.data(), num_groups, 1},
                    {directions, dim, 1},
                    rows,
                    num_groups,
                    0,
                    dim,
                    slopes.data(),
                    dim);
  for (size_t j = 0; j < rows; ++j) {
    const double share = weight * prototypes.shares[members[j].group];
    AddTurn(std::span(slopes).subspan(j * dim, dim),
            std::span(units).subspan(j * dim, dim),
            share / members[j].length,
            members[j].gradient);
  }
  return loss;
}

}  // namespace

Status ContrastiveOptions::Check() const {
  if (!(temperature >= 1e-6 && temperature <= 1e6)) {
    return InvalidArgumentError(
        "the contrastive temperature must be in [1e-6, 1e6]");
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
  const size_t num_groups = NumberGroups(&members);
  if (num_groups > kMaxGroups) {
    return InvalidArgumentError(std::to_string(num_groups) +
                                " groups to contrast, more than " +
                                std::to_string(kMaxGroups));
  }
  const Prototypes prototypes =
      MakePrototypes(dim, num_groups, options.positive_cosine, pool, &members);

  const auto count = static_cast<int64_t>(members.size());
  std::vector<double> losses((count + kMemberGrain - 1) / kMemberGrain, 0.0);
  pool.ParallelFor(
      0, count, kMemberGrain, [&](int64_t first, int64_t last, int) {
        losses[first / kMemberGrain] =
            AddBlock(options,
                     std::span(members).subspan(first, last - first),
                     prototypes,
                     weight);
      });
  double loss = 0;
  for (const double part : losses) loss += part;
  return loss;
}

}  // namespace freegs::semantics
