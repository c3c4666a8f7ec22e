// SPDX-License-Identifier: BSD-3-Clause

#include "splat/images/resolution_schedule.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "core/io/image_io.h"
#include "core/random.h"
#include "tests/splat/training_fixture.h"

namespace freegs::splat {
namespace {

// A picture of waves of so many cycles per pixel along x.
ImageF Waves(double frequency) {
  ImageF image(128, 96, 3);
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      for (int c = 0; c < 3; ++c) {
        image(x, y, c) = static_cast<float>(
            0.5 + 0.3 * std::sin(2 * std::numbers::pi * frequency * x));
      }
    }
  }
  return image;
}

TEST(SpectrumShares, AWaveBelongsToTheLevelsThatCanCarryIt) {
  // 0.2 cycles per pixel: half size carries up to 0.25, quarter size 0.125.
  const std::vector<double> shares = SpectrumShares(Waves(0.2), 3);
  ASSERT_EQ(shares.size(), 3u);
  EXPECT_DOUBLE_EQ(shares[0], 1.0);
  EXPECT_GT(shares[1], 0.95);
  EXPECT_LT(shares[2], 0.05);
}

TEST(SpectrumShares, WhiteNoiseFillsAllFrequenciesAlike) {
  ImageF image(128, 128, 3);
  for (size_t i = 0; i < image.size(); ++i) {
    image.data()[i] = static_cast<float>(RandomUniform(1, 2, i));
  }
  const std::vector<double> shares = SpectrumShares(image, 3);
  EXPECT_NEAR(shares[1], 0.25, 0.03);
  EXPECT_NEAR(shares[2], 0.0625, 0.02);
}

TEST(SpectrumShares, OneColourIsCarriedByEveryLevel) {
  for (const double share : SpectrumShares(ImageF(40, 30, 3, 0.5f), 4)) {
    EXPECT_DOUBLE_EQ(share, 1.0);
  }
}

// The left upper part of a picture of fine and coarse noise.
ImageF PartOfNoise(int width, int height) {
  ImageF image(width, height, 3);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const auto noise = [&](int size) {
        const int cell = 1000 * (y / size) + x / size;
        return RandomUniform(size, 2, static_cast<uint64_t>(cell));
      };
      for (int c = 0; c < 3; ++c) {
        image(x, y, c) = static_cast<float>((noise(1) + noise(8)) / 2);
      }
    }
  }
  return image;
}

// Prime sides are padded to those of the other picture, which are not.
TEST(SpectrumShares, PrimeSidesHaveTheSharesOfTheirNeighbours) {
  const std::vector<double> prime = SpectrumShares(PartOfNoise(241, 179), 3);
  const std::vector<double> whole = SpectrumShares(PartOfNoise(243, 180), 3);
  EXPECT_DOUBLE_EQ(prime[0], 1.0);
  EXPECT_NEAR(prime[1], whole[1], 0.001);
  EXPECT_NEAR(prime[2], whole[2], 0.001);
}

using SpectrumResolutionStepsTest = TrainingFixture;

// 96 x 72 has one level more whose shorter side is at least 32.
TEST_F(SpectrumResolutionStepsTest, AQuarterOfTheMeanShare) {
  ThreadPool pool(2);
  TrainingImages images = Images(pool);
  double mean = 0;
  for (size_t i = 0; i < images.size(); ++i) {
    ImageF photo;
    ASSERT_TRUE(images.Fetch(i, 0, &photo).ok());
    mean += SpectrumShares(photo, 2)[1] / static_cast<double>(images.size());
  }
  const StatusOr<std::vector<double>> steps = SpectrumResolutionSteps(&images);
  ASSERT_TRUE(steps.ok());
  ASSERT_EQ(steps->size(), 1u);
  EXPECT_NEAR(steps->front(), 0.25 * mean, 1e-12);
}

TEST_F(SpectrumResolutionStepsTest, SeesNothingOfWhatMasksIgnore) {
  const TemporaryFolder masks;
  ImageU8 mask(96, 72, 1, 255);
  std::fill_n(mask.data(), mask.size() / 2, uint8_t{0});
  ASSERT_TRUE(WriteImage(masks.path() / (views_[0].name + ".png"), mask).ok());
  ThreadPool pool(1);
  const auto steps = [&] {
    auto images = TrainingImages::Load(
        views_, folder_, {.mask_folder = masks.path()}, pool);
    return *SpectrumResolutionSteps(&*images);
  };
  const std::vector<double> before = steps();
  for (size_t i = 0; i < photos_[0].size() / 2; ++i) {
    photos_[0].data()[i] = static_cast<uint8_t>(RandomBits(1, 2, i));
  }
  WritePhoto(0);
  EXPECT_EQ(steps(), before);
}

}  // namespace
}  // namespace freegs::splat
