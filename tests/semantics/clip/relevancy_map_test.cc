// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/clip/relevancy_map.h"

#include <gtest/gtest.h>

#include "semantics/clip/relevancy.h"
#include "tests/random_image.h"

namespace freegs::semantics {
namespace {

TEST(RelevancyMapTest, IsTheRelevancyOfUpsampledFeatures) {
  // Wide enough for several blocks.
  constexpr int kDim = 2048;
  const ImageF features = RandomImage(4, 3, kDim, 1);
  const ImageF guide = RandomImage(90, 50, 3, 2);
  const ImageF texts = RandomImage(1, 3, kDim, 3);
  const std::span<const float> text(texts.data(), kDim);
  const std::span<const float> canonical(texts.row(1), 2 * kDim);
  ThreadPool pool(2);
  const auto map = RelevancyMap(features, guide, text, canonical, {}, pool);
  ASSERT_TRUE(map.ok()) << map.status().message();
  const auto upsampled = JointBilateralUpsample(features, guide, {}, pool);
  ASSERT_TRUE(upsampled.ok());
  ASSERT_EQ(map->num_pixels(), guide.num_pixels());
  for (int y = 0; y < guide.height(); ++y) {
    for (int x = 0; x < guide.width(); ++x) {
      ASSERT_EQ((*map)(x, y),
                Relevancy({&(*upsampled)(x, y), kDim}, text, canonical));
    }
  }
}

TEST(RelevancyMapTest, WhatIsAskedIsChecked) {
  ThreadPool pool(1);
  const ImageF features(2, 2, 3);
  const ImageF guide(4, 4, 3);
  const std::vector<float> values(8);
  const std::span<const float> all(values);
  const auto code =
      [&](const ImageF& f, const ImageF& g, size_t text, size_t canonical) {
        return RelevancyMap(
                   f, g, all.first(text), all.first(canonical), {}, pool)
            .status()
            .code();
      };
  EXPECT_EQ(code(features, guide, 3, 6), StatusCode::kOk);
  EXPECT_EQ(code(features, guide, 3, 0), StatusCode::kOk);
  EXPECT_EQ(code(features, guide, 2, 6), StatusCode::kInvalidArgument);
  EXPECT_EQ(code(features, guide, 3, 7), StatusCode::kInvalidArgument);
  EXPECT_EQ(code({}, guide, 3, 6), StatusCode::kInvalidArgument);
  EXPECT_EQ(code({}, guide, 0, 0), StatusCode::kInvalidArgument);
  EXPECT_EQ(code(features, {}, 3, 6), StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace freegs::semantics
