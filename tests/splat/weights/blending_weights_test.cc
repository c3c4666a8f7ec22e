// SPDX-License-Identifier: BSD-3-Clause

#include "splat/weights/blending_weights.h"

#include <cmath>
#include <utility>

#include <Eigen/Core>
#include <gtest/gtest.h>

#include "tests/for_each_target.h"
#include "tests/splat/dense_weights.h"
#include "tests/splat/test_scene.h"

namespace freegs::splat {
namespace {

BlendingWeights WeightsOf(const GaussianModel& model,
                          const Pinhole& camera,
                          ThreadPool& pool) {
  StatusOr<BlendingWeights> weights =
      ComputeBlendingWeights(model, camera, TestPose(), RenderOptions(), pool);
  EXPECT_TRUE(weights.ok()) << weights.status().message();
  return *std::move(weights);
}

// Expects the same Gaussians at the same pixels as the renderer has, front to
// back, with the same weights.
void ExpectTheRenderersWeights(const GaussianModel& model,
                               const Pinhole& camera) {
  ThreadPool pool(2);
  const BlendingWeights weights = WeightsOf(model, camera, pool);
  const RenderedView view = RenderDenseWeights(model, camera, TestPose(), pool);
  const size_t num_pixels = view.transmittance.num_pixels();
  ASSERT_EQ(weights.pixel_begin.size(), num_pixels + 1);
  EXPECT_EQ(weights.pixel_begin.front(), 0u);
  EXPECT_EQ(weights.pixel_begin.back(), weights.weights.size());
  EXPECT_EQ(weights.gaussians.size(), weights.weights.size());
  EXPECT_EQ(weights.num_gaussians, model.size());

  size_t rendered = 0;
  for (size_t k = 0; k < view.features.size(); ++k) {
    rendered += view.features.data()[k] != 0;
  }
  EXPECT_EQ(rendered, weights.weights.size());
  const Eigen::Matrix3d rotation = TestPose().rotation.toRotationMatrix();
  for (size_t p = 0; p < num_pixels; ++p) {
    double sum = 0;
    double last_depth = 0;
    for (uint32_t k = weights.pixel_begin[p]; k < weights.pixel_begin[p + 1];
         ++k) {
      const uint32_t i = weights.gaussians[k];
      ASSERT_LT(i, model.size());
      EXPECT_GT(weights.weights[k], 0);
      EXPECT_NEAR(
          weights.weights[k], view.features.data()[p * model.size() + i], 3e-6);
      sum += weights.weights[k];
      const double depth =
          rotation.row(2).dot(
              Eigen::Vector3f::Map(&model.means[3 * i]).cast<double>()) +
          TestPose().translation[2];
      EXPECT_GE(depth, last_depth - 1e-5);
      last_depth = depth;
    }
    EXPECT_NEAR(sum, 1 - view.transmittance.data()[p], 1e-5);
  }
}

TEST(BlendingWeights, AreThoseOfTheRenderer) {
  // Partial tiles on both sides.
  ExpectTheRenderersWeights(RandomSceneModel(200, 1, 1), TestCamera(75, 53));
}

TEST(BlendingWeights, OfASmallerImageAreThoseOfRenderingAtThatSize) {
  const Pinhole camera = TestCamera(320, 200).LimitedTo(48);
  EXPECT_EQ(camera.width, 48);
  EXPECT_EQ(camera.height, 30);
  ExpectTheRenderersWeights(RandomSceneModel(200, 0, 2), camera);
}

TEST(BlendingWeights, StopWhereTheRendererDoes) {
  // Hundreds of opaque Gaussians, one behind the other.
  GaussianModel model = RandomSceneModel(300, 0, 3);
  for (float& scale : model.log_scales) scale = std::log(0.8f);
  for (float& logit : model.opacity_logits) logit = 3;
  const Pinhole camera = TestCamera(40, 33);
  ExpectTheRenderersWeights(model, camera);
  ThreadPool pool(1);
  const BlendingWeights weights = WeightsOf(model, camera, pool);
  EXPECT_LT(weights.weights.size(), 40u * 33u * 100u);
}

TEST(BlendingWeights, SameBytesForAnyNumberOfThreads) {
  const GaussianModel model = RandomSceneModel(3000, 0, 4);
  const Pinhole camera = TestCamera(203, 131);
  ThreadPool one(1);
  const BlendingWeights expected = WeightsOf(model, camera, one);
  EXPECT_GT(expected.weights.size(), 203u * 131u);
  for (const int threads : {2, 5}) {
    ThreadPool pool(threads);
    const BlendingWeights weights = WeightsOf(model, camera, pool);
    EXPECT_EQ(weights.pixel_begin, expected.pixel_begin);
    EXPECT_EQ(weights.gaussians, expected.gaussians);
    // Above 0, none of them NaN: equal values are equal bytes.
    EXPECT_EQ(weights.weights, expected.weights);
  }
}

TEST(BlendingWeights, SameBytesInTheMemoryOfAnotherView) {
  const GaussianModel model = RandomSceneModel(3000, 0, 4);
  ThreadPool pool(2);
  const Rigid3d pose = TestPose();
  BlendingWeights reused;
  for (const auto& [width, height] :
       {std::pair(203, 131), {60, 40}, {140, 150}}) {
    const Pinhole camera = TestCamera(width, height);
    const BlendingWeights expected = WeightsOf(model, camera, pool);
    ASSERT_TRUE(
        ComputeBlendingWeights(model, camera, pose, {}, pool, &reused).ok());
    EXPECT_EQ(reused.width, width);
    EXPECT_EQ(reused.height, height);
    EXPECT_EQ(reused.pixel_begin, expected.pixel_begin);
    EXPECT_EQ(reused.gaussians, expected.gaussians);
    EXPECT_EQ(reused.weights, expected.weights);
  }
}

TEST(BlendingWeights, SameBytesForAnyInstructionSet) {
  // Small and large ones, in tiles that end within a vector.
  GaussianModel model = RandomSceneModel(3000, 0, 5);
  for (size_t i = 0; i < model.size(); i += 7) model.log_scales[3 * i] += 2;
  const Pinhole camera = TestCamera(203, 131);
  ThreadPool pool(2);
  const BlendingWeights expected = WeightsOf(model, camera, pool);
  ForEachTarget([&] {
    const BlendingWeights weights = WeightsOf(model, camera, pool);
    EXPECT_EQ(weights.pixel_begin, expected.pixel_begin);
    EXPECT_EQ(weights.gaussians, expected.gaussians);
    EXPECT_EQ(weights.weights, expected.weights);
  });
}

TEST(BlendingWeights, OfNothingAreEmptyRows) {
  ThreadPool pool(2);
  const BlendingWeights weights =
      WeightsOf(GaussianModel(), TestCamera(20, 10), pool);
  EXPECT_EQ(weights.pixel_begin, RawVector<uint32_t>(201, 0));
  EXPECT_TRUE(weights.gaussians.empty());
  EXPECT_EQ(weights.matrix().num_bytes(), 201 * sizeof(uint32_t));
}

TEST(BlendingWeights, OfDegenerateGaussiansAreInRange) {
  GaussianModel model = RandomSceneModel(60, 0, 8);
  for (size_t i = 0; i < model.size(); i += 3) {
    model.log_scales[3 * i] = 60;
    model.opacity_logits[i + 1] = NAN;
    model.rotations[4 * i + 8] = INFINITY;
  }
  ThreadPool pool(2);
  const BlendingWeights weights = WeightsOf(model, TestCamera(64, 48), pool);
  for (const float weight : weights.weights) {
    EXPECT_GT(weight, 0);
    EXPECT_LE(weight, 0.99f);
  }
}

TEST(BlendingWeights, NeedPixels) {
  ThreadPool pool(1);
  const StatusOr<BlendingWeights> weights = ComputeBlendingWeights(
      RandomSceneModel(3, 0, 1), Pinhole(), TestPose(), RenderOptions(), pool);
  ASSERT_FALSE(weights.ok());
  EXPECT_EQ(weights.status().code(), StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace freegs::splat
