// SPDX-License-Identifier: BSD-3-Clause
// Against the paper's algorithm in double; sparsity; following the model.

#include "splat/optim/adam.h"

#include <cmath>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include "tests/splat/random_model.h"

namespace freegs::splat {
namespace {

constexpr LearningRates kRates = {1e-3f, 5e-3f, 2e-3f, 5e-2f, 2.5e-3f, 1e-4f};

// Algorithm 1 of Kingma and Ba for one number, in double.
struct ReferenceAdam {
  double m = 0;
  double v = 0;
  double Step(double gradient, double rate, int t) {
    m = 0.9 * m + 0.1 * gradient;
    v = 0.999 * v + 0.001 * gradient * gradient;
    const double m_hat = m / (1 - std::pow(0.9, t));
    const double v_hat = v / (1 - std::pow(0.999, t));
    return -rate * m_hat / (std::sqrt(v_hat) + 1e-15);
  }
};

std::vector<uint32_t> All(size_t count) {
  std::vector<uint32_t> all(count);
  std::iota(all.begin(), all.end(), 0u);
  return all;
}

// Bits of parameter and moments at one Gaussian.
bool SameAt(const GaussianModel& a, const GaussianModel& b, size_t index) {
  GaussianModel left;
  GaussianModel right;
  left.sh_degree = right.sh_degree = a.sh_degree;
  left.AppendFrom(a, index);
  right.AppendFrom(b, index);
  return SameParameters(left, right);
}

TEST(AdamTest, MatchesTheAlgorithm) {
  constexpr size_t kCount = 21;
  GaussianModel model = RandomModel(kCount, 2, 1);
  const GaussianModel start = model;
  ThreadPool pool(2);
  Adam adam;
  adam.Reset(model);

  std::vector<std::vector<ReferenceAdam>> reference(kNumParameters);
  std::vector<std::vector<double>> expected(kNumParameters);
  for (const Parameter parameter : kAllParameters) {
    const auto& array = ParameterArray(start, parameter);
    const int kind = static_cast<int>(parameter);
    reference[kind].resize(array.size());
    expected[kind].assign(array.begin(), array.end());
  }
  for (int t = 1; t <= 20; ++t) {
    const GaussianGradients gradients = RandomModel(kCount, 2, 100 + t, 0.01);
    adam.Step(kRates, gradients, All(kCount), pool, &model);
    for (const Parameter parameter : kAllParameters) {
      const int kind = static_cast<int>(parameter);
      const auto& gradient = ParameterArray(gradients, parameter);
      for (size_t i = 0; i < gradient.size(); ++i) {
        expected[kind][i] +=
            reference[kind][i].Step(gradient[i], kRates[kind], t);
      }
    }
  }
  for (const Parameter parameter : kAllParameters) {
    const int kind = static_cast<int>(parameter);
    const auto& array = ParameterArray(model, parameter);
    for (size_t i = 0; i < array.size(); ++i) {
      ASSERT_NEAR(array[i], expected[kind][i], 1e-2 * kRates[kind])
          << "parameter " << kind << " float " << i;
    }
  }
}

TEST(AdamTest, OnlyTouchedGaussiansChange) {
  constexpr size_t kCount = 50;
  GaussianModel model = RandomModel(kCount, 1, 1);
  ThreadPool pool(2);
  Adam adam;
  adam.Reset(model);
  adam.Step(kRates, RandomModel(kCount, 1, 2), All(kCount), pool, &model);
  const GaussianModel before = model;
  const AdamState state_before = adam.state();

  // Runs of several lengths, and single ones.
  const std::vector<uint32_t> touched = {
      0, 3, 4, 5, 6, 7, 8, 9, 10, 11, 20, 22, 23, 49};
  adam.Step(kRates, RandomModel(kCount, 1, 3), touched, pool, &model);
  size_t next = 0;
  for (size_t i = 0; i < kCount; ++i) {
    const bool is_touched = next < touched.size() && touched[next] == i;
    if (is_touched) ++next;
    EXPECT_EQ(SameAt(model, before, i), !is_touched) << i;
    EXPECT_EQ(SameAt(adam.state().first_moments, state_before.first_moments, i),
              !is_touched);
    EXPECT_EQ(
        SameAt(adam.state().second_moments, state_before.second_moments, i),
        !is_touched);
  }
  EXPECT_EQ(adam.state().steps, 2);
}

TEST(AdamTest, SameBytesForAnyNumberOfThreads) {
  constexpr size_t kCount = 10001;
  std::vector<uint32_t> touched;
  for (uint32_t i = 0; i < kCount; ++i) {
    if (i % 7 != 3) touched.push_back(i);
  }
  std::vector<GaussianModel> results;
  for (const int threads : {1, 2, 5}) {
    ThreadPool pool(threads);
    GaussianModel model = RandomModel(kCount, 1, 1);
    Adam adam;
    adam.Reset(model);
    for (int t = 0; t < 3; ++t) {
      adam.Step(kRates, RandomModel(kCount, 1, 9 + t), touched, pool, &model);
    }
    results.push_back(model);
  }
  EXPECT_TRUE(SameParameters(results[0], results[1]));
  EXPECT_TRUE(SameParameters(results[0], results[2]));
}

TEST(AdamTest, ZeroGradientsOfAFreshStateDoNotMove) {
  GaussianModel model = RandomModel(9, 0, 1);
  const GaussianModel before = model;
  GaussianGradients gradients;
  gradients.Resize(9);
  ThreadPool pool(1);
  Adam adam;
  adam.Reset(model);
  adam.Step(kRates, gradients, All(9), pool, &model);
  EXPECT_TRUE(SameParameters(model, before));
}

TEST(AdamTest, FollowsTheModel) {
  GaussianModel model = RandomModel(6, 1, 1);
  ThreadPool pool(1);
  Adam adam;
  adam.Reset(model);
  adam.Step(kRates, RandomModel(6, 1, 2), All(6), pool, &model);
  const AdamState before = adam.state();

  adam.Select(std::vector<uint32_t>{1, 4, 5});
  adam.Append(2);
  ASSERT_EQ(adam.size(), 5u);
  EXPECT_EQ(adam.state().first_moments.means[3],
            before.first_moments.means[12]);
  EXPECT_EQ(adam.state().second_moments.sh_rest[9 * 2],
            before.second_moments.sh_rest[9 * 5]);
  EXPECT_EQ(adam.state().first_moments.rotations[4 * 3], 0.0f);
  EXPECT_EQ(adam.state().second_moments.opacity_logits[4], 0.0f);

  adam.SetShDegree(2);
  EXPECT_EQ(adam.state().first_moments.sh_rest.size(), 5u * 24);
  EXPECT_EQ(adam.state().first_moments.sh_rest[24],
            before.first_moments.sh_rest[9 * 4]);
  EXPECT_EQ(adam.state().steps, 1);
}

TEST(AdamTest, OptionsAreChecked) {
  EXPECT_TRUE(AdamOptions().Check().ok());
  EXPECT_FALSE(AdamOptions{.beta1 = 1}.Check().ok());
  EXPECT_FALSE(AdamOptions{.epsilon = 0}.Check().ok());
}

}  // namespace
}  // namespace freegs::splat
