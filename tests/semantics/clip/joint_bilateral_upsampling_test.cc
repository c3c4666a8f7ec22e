// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/clip/joint_bilateral_upsampling.h"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/random_image.h"

namespace freegs::semantics {
namespace {

// The definition, with the mean colour of each cell worked out from pixels
// whose centre lies in it; only for guides that are multiples of the grid.
double Reference(const ImageF& features,
                 const ImageF& guide,
                 const JointBilateralOptions& options,
                 int x,
                 int y,
                 int channel) {
  const int cell_width = guide.width() / features.width();
  const int cell_height = guide.height() / features.height();
  double sum = 0;
  double weights = 0;
  for (int j = 0; j < features.height(); ++j) {
    for (int i = 0; i < features.width(); ++i) {
      if (std::abs(i - x / cell_width) > options.radius ||
          std::abs(j - y / cell_height) > options.radius) {
        continue;
      }
      double color[3] = {};
      for (int v = 0; v < cell_height; ++v) {
        for (int u = 0; u < cell_width; ++u) {
          for (int c = 0; c < 3; ++c) {
            color[c] += guide(i * cell_width + u, j * cell_height + v, c) /
                        static_cast<double>(cell_width * cell_height);
          }
        }
      }
      const double dx = (x + 0.5) / cell_width - (i + 0.5);
      const double dy = (y + 0.5) / cell_height - (j + 0.5);
      double range = 0;
      for (int c = 0; c < 3; ++c) {
        range += std::pow(guide(x, y, c) - color[c], 2);
      }
      const double weight =
          std::exp(-(dx * dx + dy * dy) / 2 /
                   std::pow(options.spatial_sigma, 2)) *
          std::exp(-range / 2 / std::pow(options.range_sigma, 2));
      sum += weight * features(i, j, channel);
      weights += weight;
    }
  }
  return sum / weights;
}

TEST(JointBilateralTest, AgreesWithTheDefinition) {
  ThreadPool pool(2);
  const ImageF features = RandomImage(5, 4, 3, 1);
  const ImageF guide = RandomImage(35, 20, 3, 2);
  for (const JointBilateralOptions& options :
       {JointBilateralOptions(),
        JointBilateralOptions{
            .radius = 1, .spatial_sigma = 0.5, .range_sigma = 0.4},
        JointBilateralOptions{
            .radius = 9, .spatial_sigma = 3, .range_sigma = 1}}) {
    const auto result = JointBilateralUpsample(features, guide, options, pool);
    ASSERT_TRUE(result.ok()) << result.status().message();
    for (int y = 0; y < 20; ++y) {
      for (int x = 0; x < 35; ++x) {
        for (int c = 0; c < 3; ++c) {
          ASSERT_NEAR((*result)(x, y, c),
                      Reference(features, guide, options, x, y, c),
                      1e-5);
        }
      }
    }
  }
}

TEST(JointBilateralTest, AConstantStaysConstant) {
  ThreadPool pool(2);
  ImageF features(6, 6, 4);
  for (size_t i = 0; i < features.size(); ++i) {
    features.data()[i] = static_cast<float>(i % 4) - 1.5f;
  }
  const auto result =
      JointBilateralUpsample(features, RandomImage(50, 31, 3, 3), {}, pool);
  ASSERT_TRUE(result.ok());
  for (size_t i = 0; i < result->size(); ++i) {
    ASSERT_NEAR(result->data()[i], static_cast<float>(i % 4) - 1.5f, 1e-6);
  }
}

// A feature per side of an edge that runs through the middle of cells: the
// result changes where the guide does, not where the cells do.
TEST(JointBilateralTest, EdgesFollowTheGuide) {
  ThreadPool pool(2);
  constexpr int kEdge = 37;  // Cells are 10 pixels wide.
  ImageF guide(80, 80, 3);
  for (int y = 0; y < 80; ++y) {
    for (int x = 0; x < 80; ++x) {
      for (int c = 0; c < 3; ++c) guide(x, y, c) = x < kEdge ? 0.2f : 0.8f;
    }
  }
  ImageF features(8, 8, 2);
  for (int j = 0; j < 8; ++j) {
    for (int i = 0; i < 8; ++i) {
      const float left = i < 3 ? 1.0f : i == 3 ? 0.7f : 0.0f;
      features(i, j, 0) = left;
      features(i, j, 1) = 1 - left;
    }
  }
  const auto result = JointBilateralUpsample(features, guide, {}, pool);
  ASSERT_TRUE(result.ok());
  for (int y = 0; y < 80; ++y) {
    for (int x = 0; x < 80; ++x) {
      EXPECT_EQ((*result)(x, y, 0) > 0.5f, x < kEdge) << x << " " << y;
    }
    EXPECT_GT((*result)(kEdge - 1, y, 0), 0.8f);
    EXPECT_LT((*result)(kEdge, y, 0), 0.1f);
  }
}

TEST(JointBilateralTest, AColorUnlikeAllAroundTakesWhatIsNearest) {
  ThreadPool pool(1);
  ImageF guide(40, 40, 3);
  guide(22, 22, 0) = guide(22, 22, 1) = guide(22, 22, 2) = 1000;
  const ImageF features = RandomImage(4, 4, 5, 4);
  const auto result =
      JointBilateralUpsample(features, guide, {.range_sigma = 0.001}, pool);
  ASSERT_TRUE(result.ok());
  for (int c = 0; c < 5; ++c) {
    EXPECT_FLOAT_EQ((*result)(22, 22, c), features(2, 2, c));
  }
}

TEST(JointBilateralTest, PixelsAndThreadsDoNotMatter) {
  const ImageF features = RandomImage(14, 14, 16, 5);
  const ImageF guide = RandomImage(61, 43, 3, 6);
  ThreadPool one(1);
  const auto whole = JointBilateralUpsample(features, guide, {}, one);
  ASSERT_TRUE(whole.ok());
  std::vector<PixelIndex> pixels;
  for (int k = 0; k < 700; ++k) {
    pixels.push_back({static_cast<int>(RandomIndex(7, 0, k, 61)),
                      static_cast<int>(RandomIndex(7, 1, k, 43))});
  }
  for (const int threads : {1, 2, 5}) {
    ThreadPool pool(threads);
    const auto again = JointBilateralUpsample(features, guide, {}, pool);
    ASSERT_TRUE(again.ok());
    EXPECT_TRUE(std::equal(
        whole->data(), whole->data() + whole->size(), again->data()));
    const auto some =
        JointBilateralUpsampleAt(features, guide, pixels, {}, pool);
    ASSERT_TRUE(some.ok());
    ASSERT_EQ(some->size(), 700u * 16);
    for (size_t k = 0; k < pixels.size(); ++k) {
      for (int c = 0; c < 16; ++c) {
        ASSERT_EQ((*some)[k * 16 + c], (*whole)(pixels[k].x, pixels[k].y, c));
      }
    }
  }
}

TEST(JointBilateralTest, AGuideSmallerThanTheGrid) {
  ThreadPool pool(2);
  const auto result = JointBilateralUpsample(
      RandomImage(28, 28, 2, 8), RandomImage(5, 3, 3, 9), {}, pool);
  ASSERT_TRUE(result.ok());
  EXPECT_EQ(result->width(), 5);
  for (size_t i = 0; i < result->size(); ++i) {
    ASSERT_GE(result->data()[i], 0);
    ASSERT_LE(result->data()[i], 1);
  }
  EXPECT_TRUE(
      JointBilateralUpsampleAt(
          RandomImage(1, 1, 1, 1), RandomImage(1, 1, 3, 1), {}, {}, pool)
          .ok());
}

TEST(JointBilateralTest, WhatIsAskedIsChecked) {
  ThreadPool pool(1);
  const ImageF features(4, 4, 2);
  const ImageF guide(8, 8, 3);
  const auto code = [&pool](const ImageF& f,
                            const ImageF& g,
                            const JointBilateralOptions& options) {
    return JointBilateralUpsample(f, g, options, pool).status().code();
  };
  EXPECT_EQ(code(features, guide, {}), StatusCode::kOk);
  EXPECT_EQ(code({}, guide, {}), StatusCode::kInvalidArgument);
  EXPECT_EQ(code(features, {}, {}), StatusCode::kInvalidArgument);
  EXPECT_EQ(code(features, ImageF(8, 8, 1), {}), StatusCode::kInvalidArgument);
  const double nan = std::nan("");
  for (const JointBilateralOptions& options :
       {JointBilateralOptions{.radius = -1},
        JointBilateralOptions{.radius = 17},
        JointBilateralOptions{.spatial_sigma = 0},
        JointBilateralOptions{.spatial_sigma = nan},
        JointBilateralOptions{.range_sigma = -1},
        JointBilateralOptions{.range_sigma = HUGE_VAL}}) {
    EXPECT_EQ(code(features, guide, options), StatusCode::kInvalidArgument);
  }
  for (const PixelIndex pixel : {PixelIndex{-1, 0}, {8, 0}, {0, -1}, {0, 8}}) {
    const PixelIndex pixels[] = {pixel};
    EXPECT_EQ(JointBilateralUpsampleAt(features, guide, pixels, {}, pool)
                  .status()
                  .code(),
              StatusCode::kInvalidArgument);
  }
  // Too much to hold.
  EXPECT_EQ(code(ImageF(1, 1, 1 << 16), ImageF(256, 256, 3), {}),
            StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace freegs::semantics
