// SPDX-License-Identifier: BSD-3-Clause

#include "splat/optim/image_metrics.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "tests/random_image.h"

namespace freegs::splat {
namespace {

// The definition, window by window, with zeros outside the image. The mean over
// the pixels where the mask is not 0.
double BruteForceSsim(const ImageF& a,
                      const ImageF& b,
                      const ImageU8* mask = nullptr) {
  double total = 0;
  int count = 0;
  for (int channel = 0; channel < a.channels(); ++channel) {
    for (int y = 0; y < a.height(); ++y) {
      for (int x = 0; x < a.width(); ++x) {
        if (mask != nullptr && (*mask)(x, y) == 0) continue;
        ++count;
        double weights = 0;
        double ma = 0, mb = 0, aa = 0, bb = 0, ab = 0;
        for (int dy = -5; dy <= 5; ++dy) {
          for (int dx = -5; dx <= 5; ++dx) {
            const double w = std::exp(-(dx * dx + dy * dy) / (2 * 1.5 * 1.5));
            weights += w;
            const int px = x + dx;
            const int py = y + dy;
            if (px < 0 || py < 0 || px >= a.width() || py >= a.height()) {
              continue;
            }
            const double va = a(px, py, channel);
            const double vb = b(px, py, channel);
            ma += w * va;
            mb += w * vb;
            aa += w * va * va;
            bb += w * vb * vb;
            ab += w * va * vb;
          }
        }
        ma /= weights;
        mb /= weights;
        const double sa = aa / weights - ma * ma;
        const double sb = bb / weights - mb * mb;
        const double sab = ab / weights - ma * mb;
        total += (2 * ma * mb + 1e-4) * (2 * sab + 9e-4) /
                 ((ma * ma + mb * mb + 1e-4) * (sa + sb + 9e-4));
      }
    }
  }
  return total / count;
}

TEST(Psnr, KnownDifference) {
  const ImageF a(7, 5, 3, 0.5f);
  const ImageF b(7, 5, 3, 0.6f);
  EXPECT_NEAR(*Psnr(a, b), 20.0, 1e-5);
  EXPECT_EQ(*Psnr(a, a), kMaxPsnr);
}

TEST(Psnr, ClampsAsAFileWould) {
  const ImageF white(4, 4, 3, 1.0f);
  const ImageF brighter(4, 4, 3, 7.0f);
  EXPECT_EQ(*Psnr(white, brighter), kMaxPsnr);
  const ImageF black(4, 4, 3, 0.0f);
  EXPECT_NEAR(*Psnr(black, brighter), 0.0, 1e-12);
}

TEST(Ssim, MatchesTheDefinition) {
  // Wider and narrower than the window.
  const int sizes[][2] = {{23, 17}, {8, 30}, {3, 4}, {1, 1}};
  for (const auto& [width, height] : sizes) {
    const ImageF a = RandomImage(width, height, 3, 1);
    ImageF b = RandomImage(width, height, 3, 2);
    for (size_t i = 0; i < b.size(); ++i) {
      b.data()[i] = 0.7f * a.data()[i] + 0.3f * b.data()[i];
    }
    EXPECT_NEAR(*Ssim(a, b), BruteForceSsim(a, b), 1e-12);
  }
}

TEST(Ssim, IsOneForEqualImagesAndSymmetric) {
  const ImageF a = RandomImage(20, 20, 3, 3);
  const ImageF b = RandomImage(20, 20, 3, 4);
  EXPECT_NEAR(*Ssim(a, a), 1.0, 1e-12);
  EXPECT_NEAR(*Ssim(a, b), *Ssim(b, a), 1e-12);
  EXPECT_LT(*Ssim(a, b), 0.3);
}

TEST(Ssim, TakesTheMeanOfWhatTheMaskLeaves) {
  const ImageF a = RandomImage(23, 17, 3, 5);
  const ImageF b = RandomImage(23, 17, 3, 6);
  ImageU8 mask(23, 17, 1, 0);
  for (const int x : {0, 9, 22}) mask(x, 11) = 255;
  EXPECT_NEAR(*Ssim(a, b, &mask), BruteForceSsim(a, b, &mask), 1e-12);
  const ImageU8 all(23, 17, 1, 1);
  EXPECT_EQ(*Ssim(a, b, &all), *Ssim(a, b));
  const ImageU8 nothing(23, 17, 1, 0);
  EXPECT_EQ(Ssim(a, b, &nothing).status().code(), StatusCode::kInvalidArgument);
  const ImageU8 smaller(22, 17, 1, 1);
  EXPECT_EQ(Ssim(a, b, &smaller).status().code(), StatusCode::kInvalidArgument);
}

TEST(ImageMetrics, RefuseWhatCannotBeCompared) {
  const ImageF a(4, 4, 3);
  const ImageF b(4, 5, 3);
  EXPECT_EQ(Psnr(a, b).status().code(), StatusCode::kInvalidArgument);
  EXPECT_EQ(Ssim(a, b).status().code(), StatusCode::kInvalidArgument);
  EXPECT_FALSE(Psnr(ImageF(), ImageF()).ok());
  ImageF bad(4, 4, 3);
  bad(1, 1, 0) = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(Psnr(a, bad).ok());
  EXPECT_FALSE(Ssim(bad, a).ok());
}

}  // namespace
}  // namespace freegs::splat
