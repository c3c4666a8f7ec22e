// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/losses/joint_contrastive_loss.h"

#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include "tests/semantics/losses/gradient_check.h"

namespace freegs::semantics {
namespace {

constexpr int kDim = 7;

using Vector = std::vector<double>;

double Cosine(const double* a, const double* b) {
  double ab = 0;
  double aa = 0;
  double bb = 0;
  for (int k = 0; k < kDim; ++k) {
    ab += a[k] * b[k];
    aa += a[k] * a[k];
    bb += b[k] * b[k];
  }
  return ab / std::sqrt(aa * bb);
}

// Mean feature by group, those of no direction left out.
std::map<int32_t, Vector> Means(const Vector& features,
                                const std::vector<int32_t>& groups) {
  std::map<int32_t, Vector> means;
  for (size_t j = 0; j < groups.size(); ++j) {
    if (groups[j] < 0) continue;
    Vector& mean = means.try_emplace(groups[j], kDim, 0.0).first->second;
    for (int k = 0; k < kDim; ++k) mean[k] += features[j * kDim + k];
  }
  std::erase_if(means, [](const auto& entry) {
    const double* mean = entry.second.data();
    return std::isnan(Cosine(mean, mean));
  });
  return means;
}

// The loss as the header says, with constant means. `start` is where the
// derivative is taken: features that are zero there do not count.
double Reference(const Vector& features,
                 const Vector& start,
                 const std::vector<int32_t>& groups,
                 const std::map<int32_t, Vector>& means,
                 const ContrastiveOptions& options) {
  std::map<int32_t, std::pair<double, int>> sums;
  for (size_t j = 0; j < groups.size(); ++j) {
    const double* f = &features[j * kDim];
    const double* f0 = &start[j * kDim];
    if (!means.contains(groups[j]) || std::isnan(Cosine(f0, f0))) continue;
    const Vector& own = means.at(groups[j]);
    double positive = 0;
    double negative = 0;
    for (const auto& [group, mean] : means) {
      const double e = std::exp(Cosine(f, mean.data()) / options.temperature);
      const bool alike = group == groups[j] || Cosine(own.data(), mean.data()) >
                                                   options.positive_cosine;
      (alike ? positive : negative) += e;
    }
    double loss = 0;
    if (negative > 0) {
      loss = -std::log(positive / (positive + negative));
    }
    sums[groups[j]].first += loss;
    ++sums[groups[j]].second;
  }
  double loss = 0;
  for (const auto& [group, sum] : sums) loss += sum.first / sum.second;
  return sums.empty() ? 0 : loss / static_cast<double>(sums.size());
}

// Members of both kinds, the Gaussians first.
struct Scene {
  explicit Scene(std::vector<int32_t> ids, size_t gaussians = 8)
      : groups(std::move(ids)),
        num_gaussians(gaussians),
        features(RandomValues(groups.size() * kDim, 1)),
        gradients(features.size(), 0.0f) {}

  StatusOr<double> Loss(const ContrastiveOptions& options,
                        double weight = 1,
                        int threads = 2) {
    ThreadPool pool(threads);
    const size_t split = num_gaussians * kDim;
    const std::span<const float> f = features;
    const std::span<const int32_t> ids = groups;
    const std::span<float> g = gradients;
    return JointContrastiveLoss(
        options,
        kDim,
        {f.first(split), ids.first(num_gaussians), g.first(split)},
        {f.subspan(split), ids.subspan(num_gaussians), g.subspan(split)},
        weight,
        pool);
  }

  void ExpectAsByFormula(const ContrastiveOptions& options) {
    const Vector at = ToDouble(features);
    const std::map<int32_t, Vector> means = Means(at, groups);
    const StatusOr<double> loss = Loss(options, 0.05);
    ASSERT_TRUE(loss.ok()) << loss.status().message();
    EXPECT_NEAR(*loss, Reference(at, at, groups, means, options), 1e-5);
    const auto function = [&](const Vector& x) {
      return 0.05 * Reference(x, at, groups, means, options);
    };
    ExpectSameGradient(gradients, CentralDifferences(function, at), 1e-4);
  }

  std::vector<int32_t> groups;
  size_t num_gaussians;
  std::vector<float> features;
  std::vector<float> gradients;
};

// Groups of the same name on both sides, one only of Gaussians, one only of
// pixels, members of none, and a name that is large.
std::vector<int32_t> MixedGroups() {
  return {0, 3, 3, -1, 5, 0, 3, 0, 3, 0, 1000000000, -1, 3, 1000000000, 0};
}

constexpr ContrastiveOptions kDefaults{};

TEST(JointContrastiveLossTest, GradientIsThatOfTheFormula) {
  Scene(MixedGroups()).ExpectAsByFormula(kDefaults);
}

TEST(JointContrastiveLossTest, GradientIsThatOfTheFormulaWithAlikeGroups) {
  ContrastiveOptions options = kDefaults;
  options.positive_cosine = 0.0;  // About half of all are positives.
  options.temperature = 0.5;
  Scene(MixedGroups()).ExpectAsByFormula(options);
}

TEST(JointContrastiveLossTest, ZeroVectorsDoNotCount) {
  Scene scene(MixedGroups());
  for (const size_t zero : {4, 6, 9}) {  // 4 is all that group 5 has.
    std::fill_n(scene.features.begin() + zero * kDim, kDim, 0.0f);
  }
  scene.ExpectAsByFormula(kDefaults);
}

TEST(JointContrastiveLossTest, GroupsThatCancelOutDoNotCount) {
  Scene scene({0, 0, 1, 1, 2, 2}, 3);
  for (int k = 0; k < kDim; ++k) {
    scene.features[kDim + k] = -scene.features[k];
  }
  scene.ExpectAsByFormula(kDefaults);
  EXPECT_TRUE(AllZero(std::span(scene.gradients).first(2 * kDim)));
}

TEST(JointContrastiveLossTest, WithoutNegativesThereIsNothingToDo) {
  Scene one({2, 2, 2, 2, -1}, 2);
  EXPECT_EQ(*one.Loss(kDefaults), 0);
  EXPECT_TRUE(AllZero(one.gradients));

  ContrastiveOptions all_alike = kDefaults;
  all_alike.positive_cosine = -1;
  Scene many(MixedGroups());
  EXPECT_EQ(*many.Loss(all_alike), 0);
  EXPECT_TRUE(AllZero(many.gradients));

  Scene none({-1, -1, -1}, 1);
  EXPECT_EQ(*none.Loss(kDefaults), 0);
  EXPECT_EQ(*Scene({}, 0).Loss(kDefaults), 0);
  Scene zeros(MixedGroups());
  std::fill(zeros.features.begin(), zeros.features.end(), 0.0f);
  EXPECT_EQ(*zeros.Loss(kDefaults), 0);
  EXPECT_TRUE(AllZero(zeros.gradients));
}

TEST(JointContrastiveLossTest, EndsAtZeroWhenGroupsAreApart) {
  Scene apart({0, 0, 1, 1}, 2);  // Opposite: nothing left to gain.
  for (size_t k = 0; k < apart.features.size(); ++k) {
    const float sign = k / kDim < 2 ? 1.0f : -1.0f;
    apart.features[k] = sign * static_cast<float>(k % kDim + 1);
  }
  EXPECT_GE(*apart.Loss(kDefaults), 0);
  EXPECT_LT(*apart.Loss(kDefaults), 1e-8);
}

TEST(JointContrastiveLossTest, StaysFiniteWhenTheTemperatureIsLow) {
  ContrastiveOptions options = kDefaults;
  options.temperature = 1e-5;
  Scene scene(MixedGroups());
  EXPECT_TRUE(std::isfinite(*scene.Loss(options)));
  for (const float g : scene.gradients) EXPECT_TRUE(std::isfinite(g));
}

// Each group counts alike, whatever its size and from however many members its
// mean is taken.
TEST(JointContrastiveLossTest, DoesNotDependOnHowOftenMembersCome) {
  Scene once({0, 0, 1, 2, 0, 1, 2}, 4);
  Scene thrice({}, 4);
  for (int copy = 0; copy < 3; ++copy) {
    thrice.groups.insert(
        thrice.groups.end(), once.groups.begin(), once.groups.end());
    thrice.features.insert(
        thrice.features.end(), once.features.begin(), once.features.end());
  }
  thrice.gradients.resize(thrice.features.size(), 0.0f);
  EXPECT_NEAR(*once.Loss(kDefaults), *thrice.Loss(kDefaults), 1e-6);
}

TEST(JointContrastiveLossTest, DescentBringsGroupsTogether) {
  Scene scene(MixedGroups());
  const double before = *scene.Loss(kDefaults);
  for (int step = 0; step < 200; ++step) {
    std::fill(scene.gradients.begin(), scene.gradients.end(), 0.0f);
    ASSERT_TRUE(scene.Loss(kDefaults).ok());
    for (size_t k = 0; k < scene.features.size(); ++k) {
      scene.features[k] -= 0.5f * scene.gradients[k];
    }
  }
  EXPECT_LT(*scene.Loss(kDefaults), 0.1 * before);
}

TEST(JointContrastiveLossTest, RefusesWhatDoesNotFit) {
  Scene scene(MixedGroups());
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(),
                          std::numeric_limits<float>::infinity()}) {
    scene.features[2] = bad;
    EXPECT_EQ(scene.Loss(kDefaults).status().code(),
              StatusCode::kInvalidArgument);
  }
  EXPECT_TRUE(AllZero(scene.gradients));
  scene = Scene(MixedGroups());
  scene.gradients.pop_back();
  EXPECT_FALSE(scene.Loss(kDefaults).ok());
  scene = Scene(MixedGroups());
  scene.features.resize(scene.features.size() - 2);
  EXPECT_FALSE(scene.Loss(kDefaults).ok());
  scene = Scene(MixedGroups());
  EXPECT_FALSE(scene.Loss({.temperature = 0}).ok());
  EXPECT_FALSE(scene.Loss({.temperature = 1e-300}).ok());
  EXPECT_FALSE(scene.Loss({.temperature = std::nan("")}).ok());
  EXPECT_FALSE(scene.Loss({.positive_cosine = 1.5}).ok());
  std::vector<int32_t> each_its_own(5000);
  std::iota(each_its_own.begin(), each_its_own.end(), 0);
  EXPECT_FALSE(Scene(each_its_own).Loss(kDefaults).ok());
}

TEST(JointContrastiveLossTest, IsTheSameBytesForAnyNumberOfThreads) {
  std::vector<int32_t> groups(3000);
  for (size_t j = 0; j < groups.size(); ++j) {
    groups[j] = static_cast<int32_t>(RandomIndex(3, 1, j, 12)) - 1;
  }
  std::vector<double> losses;
  std::vector<std::vector<float>> results;
  for (const int threads : {1, 2, 5}) {
    Scene scene(groups, 1700);
    losses.push_back(*scene.Loss(kDefaults, 1, threads));
    results.push_back(scene.gradients);
  }
  for (size_t k = 1; k < losses.size(); ++k) {
    EXPECT_EQ(losses[k], losses[0]);
    EXPECT_EQ(results[k], results[0]);
  }
}

}  // namespace
}  // namespace freegs::semantics
