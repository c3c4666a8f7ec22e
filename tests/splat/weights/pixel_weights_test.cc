// SPDX-License-Identifier: BSD-3-Clause

#include "splat/weights/pixel_weights.h"

#include <gtest/gtest.h>

#include "splat/weights/blending_weights.h"
#include "tests/splat/test_scene.h"

namespace freegs::splat {
namespace {

// Every pixel of the image against the whole view's matrix.
void ExpectTheMatrixRows(const GaussianModel& model, const Pinhole& camera) {
  ThreadPool pool(2);
  const RenderOptions options;
  const auto matrix =
      ComputeBlendingWeights(model, camera, TestPose(), options, pool);
  ASSERT_TRUE(matrix.ok());
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const auto row =
          ComputePixelWeights(model, camera, TestPose(), options, x, y, pool);
      ASSERT_TRUE(row.ok());
      const uint32_t* begin = &matrix->pixel_begin[y * camera.width + x];
      ASSERT_EQ(row->size(), begin[1] - begin[0]) << x << " " << y;
      float depth = 0;
      for (size_t k = 0; k < row->size(); ++k) {
        EXPECT_EQ((*row)[k].gaussian, matrix->gaussians[*begin + k]);
        EXPECT_EQ((*row)[k].weight, matrix->weights[*begin + k]);
        EXPECT_GE((*row)[k].depth, depth);
        depth = (*row)[k].depth;
      }
    }
  }
}

TEST(PixelWeightsTest, AreTheRowsOfTheWholeView) {
  ExpectTheMatrixRows(RandomSceneModel(300, 1, 7), TestCamera(41, 35));
}

TEST(PixelWeightsTest, LongListsAndManyChunks) {
  // More than a batch of splats at a pixel; faint ones, so that all count.
  GaussianModel model = RandomSceneModel(9000, 0, 8);
  for (float& logit : model.opacity_logits) logit = -4.5f;
  ExpectTheMatrixRows(model, TestCamera(18, 5));
}

TEST(PixelWeightsTest, NoGaussiansNoWeights) {
  ThreadPool pool(2);
  const auto row = ComputePixelWeights(GaussianModel(),
                                       TestCamera(20, 20),
                                       TestPose(),
                                       RenderOptions(),
                                       3,
                                       4,
                                       pool);
  ASSERT_TRUE(row.ok());
  EXPECT_TRUE(row->empty());
}

TEST(PixelWeightsTest, PixelsOutsideTheImageAreErrors) {
  ThreadPool pool(1);
  const GaussianModel model = RandomSceneModel(3, 0, 9);
  for (const auto& [x, y] :
       {std::pair{-1, 0}, {0, -1}, {20, 0}, {0, 10}, {1 << 30, 1}}) {
    const auto row = ComputePixelWeights(
        model, TestCamera(20, 10), TestPose(), RenderOptions(), x, y, pool);
    EXPECT_EQ(row.status().code(), StatusCode::kInvalidArgument);
  }
}

}  // namespace
}  // namespace freegs::splat
