// SPDX-License-Identifier: BSD-3-Clause

#include "stages/scene/depth_image.h"

#include <limits>
#include <vector>

#include <gtest/gtest.h>

namespace freegs::stages {
namespace {

TEST(DepthImageTest, UnitIsAPowerOfTenThatIsEnough) {
  EXPECT_DOUBLE_EQ(DepthUnit(6.0), 1e-4);
  EXPECT_DOUBLE_EQ(DepthUnit(6.6), 1e-3);
  EXPECT_DOUBLE_EQ(DepthUnit(60), 1e-3);
  EXPECT_DOUBLE_EQ(DepthUnit(70000), 10);
  EXPECT_GT(DepthUnit(0), 0);
  EXPECT_GT(DepthUnit(std::numeric_limits<double>::infinity()), 0);
}

TEST(DepthImageTest, EncodesWithSaturation) {
  ImageF depth(4, 1, 1);
  depth(1, 0) = 1.2344f;
  depth(2, 0) = 65.535f;
  depth(3, 0) = 1e30f;
  const ImageU16 encoded = EncodeDepth(depth, 0.001);
  EXPECT_EQ(encoded(0, 0), 0);
  EXPECT_EQ(encoded(1, 0), 1234);
  EXPECT_EQ(encoded(2, 0), 65535);
  EXPECT_EQ(encoded(3, 0), 65535);
  // What is nearer than half a step is not nothing.
  EXPECT_EQ(EncodeDepth(depth, 10)(1, 0), 1);
  EXPECT_EQ(EncodeDepth(depth, 10)(0, 0), 0);
}

TEST(DepthImageTest, ColoursNearBrightAndNothingBlack) {
  ImageF depth(4, 1, 1);
  depth(1, 0) = 1;
  depth(2, 0) = 10;
  depth(3, 0) = 1000;
  const ImageU8 color = ColorDepth(depth, {1, 10});
  const auto sum = [&color](int x) {
    return color(x, 0, 0) + color(x, 0, 1) + color(x, 0, 2);
  };
  EXPECT_EQ(sum(0), 0);
  EXPECT_GT(sum(1), sum(2));
  EXPECT_GT(sum(2), 0);
  EXPECT_EQ(sum(2), sum(3));
}

TEST(DepthImageTest, RangeIsOfWhatViewsSee) {
  splat::GaussianModel model;
  model.Resize(2000);
  for (size_t i = 0; i < model.size(); ++i) {
    model.means[3 * i + 2] = 2.0f + 0.001f * static_cast<float>(i);
  }
  model.means[2] = 1e6f;  // A stray one far away,
  model.means[5] = -50;   // one behind the camera,
  model.means[6] = 100;   // one beside the image.
  View view;
  view.camera = {100, 100, 100, 100, 50, 50};
  const View views[] = {view};
  const DepthRange range = VisibleDepthRange(model, views);
  EXPECT_NEAR(range.near, 2.0, 0.02);
  EXPECT_NEAR(range.far, 4.0, 0.02);
  const DepthRange nothing = VisibleDepthRange(splat::GaussianModel(), views);
  EXPECT_LT(nothing.near, nothing.far);
}

}  // namespace
}  // namespace freegs::stages
