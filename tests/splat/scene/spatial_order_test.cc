// SPDX-License-Identifier: BSD-3-Clause

#include "splat/scene/spatial_order.h"

#include <cmath>
#include <limits>
#include <numeric>

#include <Eigen/Core>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/splat/test_scene.h"

namespace freegs::splat {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::UnorderedElementsAreArray;

double MeanStep(const GaussianModel& model) {
  double sum = 0;
  for (size_t i = 1; i < model.size(); ++i) {
    sum += (Eigen::Vector3f::Map(&model.means[3 * i]) -
            Eigen::Vector3f::Map(&model.means[3 * i - 3]))
               .norm();
  }
  return sum / static_cast<double>(model.size() - 1);
}

TEST(MortonOrder, NeighboursComeTogether) {
  GaussianModel model = RandomSceneModel(2000, 0, 7);
  const std::vector<uint32_t> order = MortonOrder(model);
  std::vector<uint32_t> all(model.size());
  std::iota(all.begin(), all.end(), 0);
  EXPECT_THAT(order, UnorderedElementsAreArray(all));
  const double before = MeanStep(model);
  model.Select(order);
  EXPECT_LT(MeanStep(model), 0.25 * before);
}

TEST(MortonOrder, StrayMeansAndTiesKeepTheirOrder) {
  GaussianModel model;
  EXPECT_THAT(MortonOrder(model), IsEmpty());
  model.Resize(4);  // All at the origin.
  EXPECT_THAT(MortonOrder(model), ElementsAre(0, 1, 2, 3));
  model.means[0] = std::numeric_limits<float>::quiet_NaN();
  model.means[4] = std::numeric_limits<float>::infinity();
  model.means[8] = -1e30f;
  EXPECT_THAT(MortonOrder(model), ::testing::SizeIs(4));
}

}  // namespace
}  // namespace freegs::splat
