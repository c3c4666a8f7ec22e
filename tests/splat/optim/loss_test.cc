// SPDX-License-Identifier: BSD-3-Clause
// Against the definition in double, its derivative by central differences, and
// itself with other numbers of threads.

#include "splat/optim/loss.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>

#include <gtest/gtest.h>

#include "core/random.h"
#include "tests/splat/reference_loss.h"

namespace freegs::splat {
namespace {

// A smooth pattern with noise, so that SSIM is neither 0 nor 1.
ImageF Pattern(int width, int height, uint64_t seed, double noise) {
  ImageF image(width, height, 3);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      for (int c = 0; c < 3; ++c) {
        const double smooth =
            0.5 + 0.3 * std::sin(0.4 * x + c) * std::cos(0.3 * y - c);
        const uint64_t counter = (static_cast<uint64_t>(y) * width + x) * 3 + c;
        image(x, y, c) = static_cast<float>(
            std::clamp(smooth + noise * (RandomUniform(seed, 0, counter) - 0.5),
                       0.0,
                       1.0));
      }
    }
  }
  return image;
}

Image<double> ToDouble(const ImageF& image) {
  Image<double> result(image.width(), image.height(), image.channels());
  std::copy_n(image.data(), image.size(), result.data());
  return result;
}

struct Size {
  int width;
  int height;
};

class LossSizeTest : public ::testing::TestWithParam<Size> {};

TEST_P(LossSizeTest, ValueMatchesTheDefinition) {
  const auto [width, height] = GetParam();
  const ImageF rendered = Pattern(width, height, 1, 0.3);
  const ImageF target = Pattern(width, height, 2, 0.1);
  ThreadPool pool(2);
  const auto value = [&](double ssim_weight) {
    PhotometricLoss loss({.ssim_weight = ssim_weight});
    return loss.Compute(rendered, target, pool, nullptr);
  };
  const ReferenceLoss<double> expected =
      ComputeReferenceLoss(ToDouble(rendered), ToDouble(target), 0.2);
  EXPECT_NEAR(value(0), expected.l1, 1e-6);
  EXPECT_NEAR(value(1), 1 - expected.ssim, 2e-6);
  EXPECT_NEAR(value(0.2), expected.loss, 1e-6);
}

TEST_P(LossSizeTest, GradientMatchesCentralDifferences) {
  const auto [width, height] = GetParam();
  const ImageF rendered = Pattern(width, height, 3, 0.3);
  const ImageF target = Pattern(width, height, 4, 0.1);
  ThreadPool pool(1);
  PhotometricLoss loss;
  ImageF gradient;
  loss.Compute(rendered, target, pool, &gradient);
  ASSERT_EQ(gradient.width(), width);
  ASSERT_EQ(gradient.height(), height);

  Image<double> moved = ToDouble(rendered);
  const Image<double> fixed = ToDouble(target);
  const double scale = 1.0 / static_cast<double>(rendered.size());
  // Every entry of small images, a sample with the corners of larger ones.
  const size_t step = rendered.size() > 400 ? 97 : 1;
  for (size_t i = 0; i < rendered.size(); i += step) {
    const double value = moved.data()[i];
    const double distance = value - fixed.data()[i];
    if (std::abs(distance) < 1e-4) continue;  // The kink of L1.
    constexpr double kStep = 1e-5;
    moved.data()[i] = value + kStep;
    const double above = ComputeReferenceLoss(moved, fixed, 0.2).loss;
    moved.data()[i] = value - kStep;
    const double below = ComputeReferenceLoss(moved, fixed, 0.2).loss;
    moved.data()[i] = value;
    const double expected = (above - below) / (2 * kStep);
    ASSERT_NEAR(gradient.data()[i] / scale, expected / scale, 2e-3)
        << "float " << i;
  }
}

INSTANTIATE_TEST_SUITE_P(Sizes,
                         LossSizeTest,
                         ::testing::Values(Size{1, 1},
                                           Size{2, 5},
                                           Size{7, 3},
                                           Size{13, 11},
                                           Size{33, 24}),
                         [](const auto& info) {
                           return std::to_string(info.param.width) + "x" +
                                  std::to_string(info.param.height);
                         });

TEST(LossTest, SameBytesForAnyNumberOfThreads) {
  const ImageF rendered = Pattern(61, 83, 5, 0.5);
  const ImageF target = Pattern(61, 83, 6, 0.2);
  ThreadPool one(1);
  PhotometricLoss reference;
  ImageF expected;
  const float expected_value =
      reference.Compute(rendered, target, one, &expected);
  for (const int threads : {2, 3, 7}) {
    ThreadPool pool(threads);
    PhotometricLoss loss;
    ImageF gradient;
    EXPECT_EQ(loss.Compute(rendered, target, pool, &gradient), expected_value);
    EXPECT_EQ(
        std::memcmp(
            gradient.data(), expected.data(), expected.size() * sizeof(float)),
        0);
  }
}

TEST(LossTest, WorkspaceSurvivesOtherSizes) {
  ThreadPool pool(2);
  PhotometricLoss reused;
  ImageF gradient;
  for (const Size size : {Size{40, 30}, Size{9, 50}, Size{64, 8}, Size{3, 3}}) {
    const ImageF rendered = Pattern(size.width, size.height, 7, 0.5);
    const ImageF target = Pattern(size.width, size.height, 8, 0.5);
    PhotometricLoss fresh;
    ImageF expected;
    EXPECT_EQ(reused.Compute(rendered, target, pool, &gradient),
              fresh.Compute(rendered, target, pool, &expected));
    ASSERT_EQ(gradient.size(), expected.size());
    EXPECT_TRUE(std::equal(
        gradient.data(), gradient.data() + gradient.size(), expected.data()));
  }
}

TEST(LossTest, EqualImagesHaveNoLossAndNoGradient) {
  const ImageF image = Pattern(20, 20, 9, 0.5);
  ThreadPool pool(1);
  PhotometricLoss loss;
  ImageF gradient;
  EXPECT_NEAR(loss.Compute(image, image, pool, &gradient), 0.0f, 1e-6f);
  for (size_t i = 0; i < gradient.size(); ++i) {
    EXPECT_NEAR(gradient.data()[i] * gradient.size(), 0.0f, 2e-3f);
  }
}

TEST(LossTest, FlatBlackImagesStayFinite) {
  const ImageF black(16, 16, 3, 0.0f);
  const ImageF white(16, 16, 3, 1.0f);
  ThreadPool pool(1);
  PhotometricLoss loss;
  ImageF gradient;
  for (const ImageF* target : {&black, &white}) {
    EXPECT_TRUE(std::isfinite(loss.Compute(black, *target, pool, &gradient)));
    EXPECT_TRUE(std::all_of(gradient.data(),
                            gradient.data() + gradient.size(),
                            [](float v) { return std::isfinite(v); }));
  }
}

TEST(LossTest, OptionsAreChecked) {
  EXPECT_TRUE(PhotometricLossOptions().Check().ok());
  EXPECT_FALSE(PhotometricLossOptions{.ssim_weight = 1.5}.Check().ok());
  EXPECT_FALSE(PhotometricLossOptions{.ssim_weight = NAN}.Check().ok());
}

}  // namespace
}  // namespace freegs::splat
