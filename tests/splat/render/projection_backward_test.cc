// SPDX-License-Identifier: BSD-3-Clause
// The update in chunks against the one with gradients of the whole model.

#include "splat/render/projection_backward.h"

#include <atomic>
#include <cstring>
#include <vector>

#include <gtest/gtest.h>

#include "core/random.h"
#include "splat/optim/adam.h"
#include "splat/render/rasterizer.h"
#include "splat/train/stability.h"
#include "tests/splat/test_scene.h"

namespace freegs::splat {
namespace {

constexpr LearningRates kLearningRates = {
    1e-3f, 5e-3f, 2e-3f, 5e-2f, 2.5e-3f, 1e-4f};
constexpr double kSceneExtent = 2;

// Bytes, not values: memcmp also tells -0 from 0.
bool SameBytes(const GaussianModel& a, const GaussianModel& b) {
  for (const Parameter parameter : kAllParameters) {
    const std::vector<float>& left = ParameterArray(a, parameter);
    const std::vector<float>& right = ParameterArray(b, parameter);
    if (left.size() != right.size() ||
        std::memcmp(left.data(), right.data(), left.size() * sizeof(float))) {
      return false;
    }
  }
  return true;
}

// Single Gaussians, short runs and whole chunks are out of sight.
GaussianModel ModelWithGaps() {
  GaussianModel model = RandomSceneModel(1500, 3, 8);
  for (size_t i = 0; i < model.size(); ++i) {
    const bool hidden = i % 11 == 3 || i / 5 % 7 == 2 || i / 300 == 1;
    if (hidden) model.opacity_logits[i] = -20;
  }
  // To be bounded.
  model.log_scales[0] = -50;
  for (int k = 0; k < 4; ++k) model.rotations[4 * 30 + k] *= 100;
  return model;
}

struct Training {
  Training() {
    options.sh_degree = 2;  // Less than the model's.
    adam.Reset(model);
    RandomStream random(4, 4);
    for (size_t i = 0; i < d_color.size(); ++i) {
      d_color.data()[i] = static_cast<float>(0.01 * random.Normal());
    }
  }

  void Forward(ThreadPool& pool) {
    rasterizer.Forward(model, camera, TestPose(), options, {}, pool, &images);
  }

  Pinhole camera = TestCamera(120, 90);
  RenderOptions options;
  GaussianModel model = ModelWithGaps();
  Adam adam;
  Rasterizer rasterizer;
  RasterImages images;
  ImageF d_color{120, 90, 3};
};

TEST(ProjectionBackward, ChunksGiveTheBytesOfSeparatePasses) {
  constexpr int kSteps = 3;
  ThreadPool pool(2);
  Training separate;
  GaussianGradients gradients = separate.model;
  for (int step = 0; step < kSteps; ++step) {
    separate.Forward(pool);
    separate.rasterizer.Backward(separate.model,
                                 {.color = &separate.d_color},
                                 separate.images,
                                 pool,
                                 &gradients);
    const std::vector<uint32_t>& visible =
        separate.rasterizer.projection().visible;
    ASSERT_GT(visible.size(), 500u);
    ASSERT_LT(visible.size(), 1200u);
    separate.adam.Step(
        kLearningRates, gradients, visible, pool, &separate.model);
    EXPECT_TRUE(BoundParameters(kSceneExtent, visible, &separate.model));
  }
  ASSERT_FALSE(SameBytes(separate.model, ModelWithGaps()));

  for (const int threads : {1, 2, 5}) {
    ThreadPool own_pool(threads);
    Training fused;
    for (int step = 0; step < kSteps; ++step) {
      fused.Forward(own_pool);
      fused.adam.BeginStep(kLearningRates);
      std::atomic<size_t> updated = 0;
      fused.rasterizer.BackwardInChunks(
          fused.model,
          {.color = &fused.d_color},
          fused.images,
          own_pool,
          [&](std::span<const uint32_t> visible,
              const GaussianGradients& rows) {
            updated += visible.size();
            fused.adam.UpdateRows(visible, rows, &fused.model);
            BoundParameters(kSceneExtent, visible, &fused.model);
          });
      EXPECT_EQ(updated, fused.rasterizer.projection().size());
    }
    EXPECT_TRUE(SameBytes(fused.model, separate.model)) << threads;
    EXPECT_TRUE(SameBytes(fused.adam.state().first_moments,
                          separate.adam.state().first_moments));
    EXPECT_TRUE(SameBytes(fused.adam.state().second_moments,
                          separate.adam.state().second_moments));
    EXPECT_EQ(fused.adam.state().steps, kSteps);
  }
}

}  // namespace
}  // namespace freegs::splat
