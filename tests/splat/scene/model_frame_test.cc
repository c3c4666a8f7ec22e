// SPDX-License-Identifier: BSD-3-Clause

#include "splat/scene/model_frame.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "splat/scene/ply_io.h"
#include "tests/splat/random_model.h"

namespace freegs::splat {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

GaussianModel RoundedModel() {
  GaussianModel model = RandomModel(200, 1, 11, 6.0);
  RoundToGrid(&model);
  return model;
}

GaussianModel ThroughAFile(const GaussianModel& model,
                           const ModelFrame& frame) {
  const PlacedModel world = ToWorld(model, frame);
  const StatusOr<PlacedModel> read =
      ParsePly(SerializePly(world.model, world.offset));
  EXPECT_TRUE(read.ok()) << read.status().message();
  return read.ok() ? ToFrame(*read, frame) : GaussianModel();
}

TEST(ModelFrameTest, SameBitsThroughAFileInAnyUnit) {
  const GaussianModel model = RoundedModel();
  for (const double unit : {1.0, 1e-3, 0.37, 1e4, 1e-9}) {
    for (const Eigen::Vector3d& direction :
         {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(7, -3, 11)}) {
      const ModelFrame frame{unit * direction, unit};
      EXPECT_TRUE(SameParameters(model, ThroughAFile(model, frame))) << unit;
    }
  }
}

TEST(ModelFrameTest, FarScenesCountFromAnOffset) {
  const GaussianModel model = RoundedModel();
  const ModelFrame frame{{4.1e6, -2.3e6, 5.2e6}, 0.1};
  ASSERT_TRUE(frame.IsFarAway());
  const PlacedModel world = ToWorld(model, frame);
  EXPECT_EQ(world.offset, frame.origin);
  EXPECT_THAT(SerializePly(world.model, world.offset),
              HasSubstr("\ncomment offset 4100000 -2300000 5200000\n"));
  EXPECT_TRUE(SameParameters(model, ThroughAFile(model, frame)));
  // A file of another program that holds the world's own numbers.
  PlacedModel foreign = world;
  for (size_t k = 0; k < foreign.model.means.size(); ++k) {
    foreign.model.means[k] += static_cast<float>(world.offset[k % 3]);
  }
  foreign.offset.setZero();
  const GaussianModel coarse = ToFrame(foreign, frame);
  for (size_t k = 0; k < model.means.size(); ++k) {
    EXPECT_NEAR(coarse.means[k], model.means[k], 0.25 / frame.unit);
  }
}

TEST(ModelFrameTest, NearScenesHaveTheWorldsOwnNumbers) {
  const ModelFrame frame{{300, 200, -100}, 2};
  EXPECT_FALSE(frame.IsFarAway());
  GaussianModel model = RoundedModel();
  model.means[0] = 1.5;
  model.log_scales[0] = -2;
  const PlacedModel world = ToWorld(model, frame);
  EXPECT_TRUE(world.offset.isZero(0));
  EXPECT_EQ(world.model.means[0], 303.0f);
  EXPECT_FLOAT_EQ(world.model.log_scales[0],
                  static_cast<float>(-2 + std::log(2.0)));
  EXPECT_THAT(SerializePly(world.model), Not(HasSubstr("offset")));
}

TEST(ModelFrameTest, RoundingIsFine) {
  const GaussianModel model = RandomModel(500, 0, 3, 20.0);
  GaussianModel rounded = model;
  RoundToGrid(&rounded);
  for (size_t k = 0; k < model.means.size(); ++k) {
    EXPECT_NEAR(rounded.means[k],
                model.means[k],
                2e-6 * std::max(4.0f, std::abs(model.means[k])));
    EXPECT_NEAR(rounded.log_scales[k], model.log_scales[k], 3.1e-5);
  }
}

TEST(ModelFrameTest, OtherCommentsAreNoOffset) {
  const std::string content = SerializePly(RoundedModel(), {1, 2, 3});
  for (const char* comment : {"comment offset 1 2 x", "comment offset 1 2"}) {
    std::string other = content;
    other.replace(other.find("comment offset 1 2 3"), 20, comment);
    const StatusOr<PlacedModel> read = ParsePly(other);
    ASSERT_TRUE(read.ok()) << read.status().message();
    EXPECT_TRUE(read->offset.isZero(0)) << comment;
  }
}

}  // namespace
}  // namespace freegs::splat
