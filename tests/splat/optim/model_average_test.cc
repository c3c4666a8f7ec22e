// SPDX-License-Identifier: BSD-3-Clause

#include "splat/optim/model_average.h"

#include <vector>

#include <gtest/gtest.h>

#include "core/parallel.h"
#include "tests/splat/random_model.h"

namespace freegs::splat {
namespace {

constexpr size_t kCount = 3000;

std::vector<GaussianModel> Models() {
  std::vector<GaussianModel> models;
  for (const uint64_t seed : {1, 2, 3, 4, 5}) {
    models.push_back(RandomModel(kCount, 2, seed));
  }
  return models;
}

TEST(ModelAverageTest, IsTheMeanOfEachParameter) {
  ThreadPool pool(2);
  ModelAverage average;
  const std::vector<GaussianModel> models = Models();
  for (const GaussianModel& model : models) average.Add(model, pool);
  EXPECT_EQ(average.count, 5);
  for (const Parameter parameter : kAllParameters) {
    const std::vector<float>& means = ParameterArray(average.mean, parameter);
    ASSERT_EQ(means.size(), ParameterArray(models[0], parameter).size());
    for (size_t i = 0; i < means.size(); ++i) {
      double sum = 0;
      for (const GaussianModel& model : models) {
        sum += ParameterArray(model, parameter)[i];
      }
      ASSERT_NEAR(means[i], sum / 5, 1e-5);
    }
  }
}

TEST(ModelAverageTest, SameBytesForAnyNumberOfThreads) {
  ThreadPool one(1);
  ThreadPool three(3);
  ModelAverage a;
  ModelAverage b;
  for (const GaussianModel& model : Models()) {
    a.Add(model, one);
    b.Add(model, three);
  }
  EXPECT_TRUE(SameParameters(a.mean, b.mean));
}

TEST(ModelAverageTest, BeginsAgainWithOtherGaussians) {
  ThreadPool pool(1);
  ModelAverage average;
  average.Add(RandomModel(kCount, 2, 1), pool);
  for (const GaussianModel& other :
       {RandomModel(kCount + 1, 2, 2), RandomModel(kCount + 1, 1, 3)}) {
    average.Add(other, pool);
    EXPECT_EQ(average.count, 1);
    EXPECT_TRUE(SameParameters(average.mean, other));
  }
  average.Clear();
  EXPECT_EQ(average.count, 0);
  EXPECT_TRUE(average.mean.empty());
  const GaussianModel next = RandomModel(kCount, 0, 4);
  average.Add(next, pool);
  EXPECT_TRUE(SameParameters(average.mean, next));
}

}  // namespace
}  // namespace freegs::splat
