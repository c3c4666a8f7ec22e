// SPDX-License-Identifier: BSD-3-Clause

#include "splat/optim/exposure.h"

#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/random.h"
#include "tests/random_image.h"

namespace freegs::splat {
namespace {

AffineColor RandomColor(uint64_t seed) {
  AffineColor color;
  for (size_t i = 0; i < 12; ++i) {
    color.values[i] += static_cast<float>(0.2 * RandomNormal(seed, 2, i));
  }
  return color;
}

TEST(Exposure, OfAnUnknownPhotoIsBetweenThoseOfItsNeighbours) {
  const std::vector<PhotoExposure> exposures = {{"2.jpg", RandomColor(1)},
                                                {"4.jpg", RandomColor(2)}};
  EXPECT_EQ(ExposureBetween({}, "3.jpg"), AffineColor());
  EXPECT_EQ(ExposureBetween(exposures, "1.jpg"), exposures[0].color);
  EXPECT_EQ(ExposureBetween(exposures, "5.jpg"), exposures[1].color);
  // What was learnt of the photo itself does not count.
  EXPECT_EQ(ExposureBetween(exposures, "2.jpg"), exposures[1].color);
  EXPECT_EQ(ExposureBetween(exposures, "4.jpg"), exposures[0].color);
  EXPECT_EQ(ExposureBetween({exposures.data(), 1}, "2.jpg"), AffineColor());
  const AffineColor between = ExposureBetween(exposures, "3.jpg");
  for (size_t k = 0; k < between.values.size(); ++k) {
    EXPECT_FLOAT_EQ(
        between.values[k],
        (exposures[0].color.values[k] + exposures[1].color.values[k]) / 2);
  }
}

TEST(Exposure, InverseLeadsBackToTheScene) {
  ThreadPool pool(1);
  const ImageF scene = RandomImage(7, 5, 3, 3);
  const AffineColor color = RandomColor(4);
  ImageF photo;
  ImageF back;
  ApplyColor(color, scene, pool, &photo);
  ApplyColor(Inverse(color), photo, pool, &back);
  for (size_t i = 0; i < scene.size(); ++i) {
    EXPECT_NEAR(back.data()[i], scene.data()[i], 1e-5);
  }
  AffineColor black;
  black.values.fill(0);
  EXPECT_EQ(Inverse(black), AffineColor());
}

TEST(Exposure, NeighboursAreThoseThatPeopleCount) {
  const std::vector<PhotoExposure> exposures = {{"8.jpg", RandomColor(1)},
                                                {"10.jpg", RandomColor(2)}};
  const AffineColor between = ExposureBetween(exposures, "9.jpg");
  EXPECT_FLOAT_EQ(
      between.values[0],
      (exposures[0].color.values[0] + exposures[1].color.values[0]) / 2);
}

TEST(Exposure, NumbersSayHowFarNeighboursAre) {
  const AffineColor a = RandomColor(1);
  const AffineColor b = RandomColor(2);
  const auto share_of_last = [&](const std::string& before,
                                 const std::string& photo,
                                 const std::string& after) {
    const std::vector<PhotoExposure> exposures = {{before, a}, {after, b}};
    const AffineColor between = ExposureBetween(exposures, photo);
    return (between.values[3] - a.values[3]) / (b.values[3] - a.values[3]);
  };
  EXPECT_NEAR(share_of_last("v2/f_0008.jpg", "v2/f_0009.jpg", "v2/f_0012.jpg"),
              0.25,
              1e-6);
  EXPECT_NEAR(share_of_last("98.jpg", "99.jpg", "108.jpg"), 0.1, 1e-6);
  EXPECT_NEAR(share_of_last("img-9", "img-10", "img-13"), 0.25, 1e-6);
  // Nothing is known where names differ in something else or in a number that
  // is too long.
  for (const auto& [before, photo, after] :
       {std::array{"a/1.jpg", "b/1.jpg", "b/5.jpg"},
        std::array{"1.jpg", "2.jpg", "5.png"},
        std::array{"01.jpg", "1.jpg", "5.jpg"},
        std::array{"a.jpg", "b.jpg", "e.jpg"},
        std::array{"a", "a1", "a9"},
        std::array{"1.jpg", "2.jpg", "99999999999999999999999.jpg"},
        std::array{"1_20.jpg", "2_10.jpg", "5_10.jpg"}}) {
    EXPECT_NEAR(share_of_last(before, photo, after), 0.5, 1e-6) << photo;
  }
}

TEST(Exposure, AppliesTheMatrix) {
  ThreadPool pool(2);
  const ImageF scene = RandomImage(7, 40, 3, 1);
  const AffineColor color = RandomColor(1);
  ImageF photo;
  ApplyColor(color, scene, pool, &photo);
  for (int k = 0; k < 3; ++k) {
    double expected = color.values[4 * k + 3];
    for (int c = 0; c < 3; ++c) {
      expected += color.values[4 * k + c] * scene(3, 33, c);
    }
    EXPECT_NEAR(photo(3, 33, k), expected, 1e-6);
  }
  ApplyColor({}, scene, pool, &photo);
  EXPECT_EQ(photo(6, 39, 2), scene(6, 39, 2));
}

// L = sum of w * photo is linear in scene and in the matrix, so differences of
// any size give its derivatives.
TEST(Exposure, DerivativesAreThoseOfDifferences) {
  ThreadPool pool(2);
  const ImageF scene = RandomImage(9, 37, 3, 3);
  const ImageF weights = RandomImage(9, 37, 3, 4);
  const AffineColor color = RandomColor(5);
  const auto loss = [&](const AffineColor& c, const ImageF& s) {
    ImageF photo;
    ApplyColor(c, s, pool, &photo);
    double sum = 0;
    for (size_t i = 0; i < photo.size(); ++i) {
      sum += static_cast<double>(photo.data()[i]) * weights.data()[i];
    }
    return sum;
  };
  ImageF gradient = weights;
  std::vector<ColorSums> scratch;
  const AffineColor d_color =
      BackwardColor(color, scene, pool, &scratch, &gradient);
  for (int i = 0; i < 12; ++i) {
    AffineColor high = color, low = color;
    high.values[i] += 0.25f;
    low.values[i] -= 0.25f;
    EXPECT_NEAR(
        d_color.values[i], 2 * (loss(high, scene) - loss(low, scene)), 1e-3);
  }
  for (const int i : {0, 1, 2, 500, 9 * 37 * 3 - 1}) {
    ImageF high = scene, low = scene;
    high.data()[i] += 0.25f;
    low.data()[i] -= 0.25f;
    EXPECT_NEAR(
        gradient.data()[i], 2 * (loss(color, high) - loss(color, low)), 1e-3);
  }
  // One thread gives the same bytes.
  ThreadPool one(1);
  ImageF again = weights;
  EXPECT_EQ(BackwardColor(color, scene, one, &scratch, &again), d_color);
}

TEST(Exposure, TheMeanOfAllPhotosStays) {
  PhotoColors colors;
  colors.entries.resize(5);
  for (uint64_t step = 0; step < 200; ++step) {
    AffineColor gradient = RandomColor(step);
    if (step == 50) {
      gradient.values[3] = std::numeric_limits<float>::quiet_NaN();
    }
    colors.Step(step % 3, gradient, 0.01, 1);
  }
  for (int i = 0; i < 12; ++i) {
    double mean = 0;
    for (const PhotoColors::Entry& entry : colors.entries) {
      mean += entry.color.values[i] / 5;
    }
    EXPECT_NEAR(mean, AffineColor().values[i], 1e-5);
  }
  EXPECT_NE(colors.entries[0].color, AffineColor());
}

TEST(Exposure, FitFindsTheColours) {
  ThreadPool pool(1);
  const ImageF scene = RandomImage(40, 20, 3, 8);
  const AffineColor color = RandomColor(9);
  ImageF photo;
  ApplyColor(color, scene, pool, &photo);
  ImageU8 mask(40, 20, 1, 255);
  for (int y = 0; y < 20; ++y) {
    for (int x = 20; x < 40; ++x) photo(x, y, 0) = 0;  // Not looked at.
    photo(5, y, 1) = 7;
    mask(5, y) = 0;
  }
  const AffineColor fit = FitColor(scene, photo, &mask, 0, 20);
  for (int i = 0; i < 12; ++i) {
    EXPECT_NEAR(fit.values[i], color.values[i], 2e-3);
  }
  EXPECT_EQ(FitColor(scene, photo, nullptr, 0, 1), AffineColor());
  // A photo of one colour only tells a shift; no number grows without bound.
  const ImageF grey(40, 20, 3, 0.5f);
  const AffineColor flat =
      FitColor(grey, ImageF(40, 20, 3, 0.7f), nullptr, 0, 40);
  ImageF shown;
  ApplyColor(flat, grey, pool, &shown);
  EXPECT_NEAR(shown(3, 3, 1), 0.7, 1e-3);
  for (const float value : flat.values) EXPECT_LT(std::abs(value), 1.5);
}

TEST(Exposure, OptionsMustMakeSense) {
  EXPECT_TRUE(ExposureOptions().Check().ok());
  EXPECT_FALSE(ExposureOptions{.start = 1}.Check().ok());
  EXPECT_FALSE(ExposureOptions{.rate_initial = 0}.Check().ok());
  EXPECT_FALSE(ExposureOptions{.pull = -1}.Check().ok());
  EXPECT_NEAR(ExposureRate({}, 0.1), 0.01, 1e-9);
  EXPECT_NEAR(ExposureRate({}, 1), 0.001, 1e-9);
}

}  // namespace
}  // namespace freegs::splat
