// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/field/feature_grids.h"

#include <gtest/gtest.h>

#include "core/io/image_io.h"
#include "semantics/clip/opencv_clip.h"
#include "semantics/geometry/directions.h"
#include "tests/semantics/clip/model_files.h"

namespace freegs::semantics {
namespace {

TEST(FeatureGridsTest, AModelsUpsamplerReplacesTheGrid) {
  const ModelCopy model;
  model.AddUpsampler();
  const auto encoder = OpenCvClip::Open(model.path());
  ASSERT_TRUE(encoder.ok()) << encoder.status().message();
  const auto photo = ReadRgb(TinyClip() / "reference.png");
  ASSERT_TRUE(photo.ok());
  const TemporaryFolder folder;
  const FeatureCache cache(folder / "cache");
  ThreadPool pool(2);
  // As many axes as channels, so that nothing is dropped.
  FeatureGridOptions options;
  options.dim = 8;
  const auto compute = [&] {
    return ComputeFeatureGrids(
        1,
        [&](size_t) -> StatusOr<ImageU8> { return *photo; },
        **encoder,
        cache,
        options,
        pool,
        nullptr,
        [](size_t) {});
  };
  const auto grids = compute();
  ASSERT_TRUE(grids.ok()) << grids.status().message();
  EXPECT_TRUE(grids->upsampled);
  ASSERT_EQ(grids->grids[0].width(), 16);

  const auto coarse = EncodeDenseCached(**encoder, cache, "x", *photo);
  auto expected = (*encoder)->Upsample(*coarse, *photo);
  ASSERT_TRUE(expected.ok()) << expected.status().message();
  MakeUnitRows(8, std::span(expected->data(), expected->size()));
  const ImageF& grid = grids->grids[0];
  const std::vector<float> values =
      ExpandFromAxes(grids->axes, std::span(grid.data(), grid.size()), pool);
  ASSERT_EQ(values.size(), expected->size());
  for (size_t i = 0; i < values.size(); ++i) {
    ASSERT_NEAR(values[i], expected->data()[i], 1e-3) << i;
  }

  // Read at twice its size, between the cells; at some pixels the same.
  const ImageF guide(32, 32, 3);
  const auto image = UpsampleView(*grids, 0, guide, {}, pool);
  ASSERT_TRUE(image.ok());
  const float* row = grid.data() + 8 * 5 * 16;  // Row 5; pixels 10 and 11.
  const float* below = row + 8 * 16;
  const float* pixel = image->data() + 8 * (11 * 32 + 7);
  for (int c = 0; c < 8; ++c) {
    const float left = 0.75f * row[8 * 3 + c] + 0.25f * below[8 * 3 + c];
    const float right = 0.75f * row[8 * 4 + c] + 0.25f * below[8 * 4 + c];
    EXPECT_NEAR(pixel[c], 0.75f * left + 0.25f * right, 1e-5) << c;
  }
  const std::vector<PixelIndex> pixels = {{7, 11}, {0, 0}, {31, 31}};
  const auto some = UpsampleViewAt(*grids, 0, guide, pixels, {}, pool);
  ASSERT_TRUE(some.ok());
  for (size_t k = 0; k < pixels.size(); ++k) {
    for (int c = 0; c < 8; ++c) {
      const size_t at = (pixels[k].y * 32 + pixels[k].x) * 8 + c;
      EXPECT_EQ((*some)[8 * k + c], image->data()[at]);
    }
  }

  // It belongs to the default size only.
  options.dense_size = 32;
  const auto other = compute();
  ASSERT_TRUE(other.ok());
  EXPECT_FALSE(other->upsampled);
  EXPECT_EQ(other->grids[0].width(), 4);
}

}  // namespace
}  // namespace freegs::semantics
