// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/metrics/boundary_iou.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "core/random.h"

namespace freegs::semantics {
namespace {

ImageU8 Square(int size, int x0, int y0, int side) {
  ImageU8 mask(size, size, 1);
  for (int y = y0; y < y0 + side; ++y) {
    for (int x = x0; x < x0 + side; ++x) mask(x, y) = 1;
  }
  return mask;
}

int64_t Count(const ImageU8& mask) {
  return std::count_if(
      mask.data(), mask.data() + mask.size(), [](uint8_t v) { return v != 0; });
}

TEST(BoundaryWidth, IsTwoPercentOfTheDiagonal) {
  EXPECT_EQ(BoundaryWidth(640, 480), 16);
  EXPECT_EQ(BoundaryWidth(100, 100), 3);  // 2.83.
  EXPECT_EQ(BoundaryWidth(4, 3), 1);
}

TEST(MaskBoundary, CountsByHand) {
  EXPECT_EQ(Count(*MaskBoundary(Square(100, 10, 10, 20), 3)), 400 - 196);
  // The border of the image is an outline.
  EXPECT_EQ(Count(*MaskBoundary(Square(10, 0, 0, 10), 2)), 100 - 36);
  // Nothing is far inside.
  EXPECT_EQ(Count(*MaskBoundary(Square(10, 2, 2, 4), 2)), 16);
  EXPECT_EQ(Count(*MaskBoundary(ImageU8(5, 7, 1), 2)), 0);
}

TEST(MaskBoundary, IsWhatLiesNearTheOutside) {
  constexpr int kWidth = 23;
  constexpr int kHeight = 17;
  RandomStream random(3, 1);
  ImageU8 mask(kWidth, kHeight, 1);
  for (size_t i = 0; i < mask.size(); ++i) {
    mask.data()[i] = random.Uniform() < 0.95 ? 7 : 0;
  }
  for (const int distance : {1, 2, 5}) {
    const ImageU8 boundary = *MaskBoundary(mask, distance);
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        bool near_outside = false;
        for (int dy = -distance; dy <= distance; ++dy) {
          for (int dx = -distance; dx <= distance; ++dx) {
            const int u = x + dx;
            const int v = y + dy;
            near_outside = near_outside || u < 0 || v < 0 || u >= kWidth ||
                           v >= kHeight || mask(u, v) == 0;
          }
        }
        EXPECT_EQ(boundary(x, y) != 0, mask(x, y) != 0 && near_outside);
      }
    }
  }
}

TEST(BoundaryIou, OfShiftedSquaresByHand) {
  // Boundaries of 204 pixels each; 19 x 20 pixels are in both squares, of which
  // 210 are inner pixels of one or the other.
  const ImageU8 a = Square(100, 10, 10, 20);
  const ImageU8 b = Square(100, 11, 10, 20);
  EXPECT_DOUBLE_EQ(*BoundaryIou(a, b), 170.0 / 238);
  EXPECT_DOUBLE_EQ(*BoundaryIou(a, a), 1);
}

TEST(BoundaryIou, OfEmptyMasksIsZero) {
  const ImageU8 empty(100, 100, 1);
  EXPECT_EQ(*BoundaryIou(empty, empty), 0);
  EXPECT_EQ(*BoundaryIou(empty, Square(100, 3, 3, 9)), 0);
  EXPECT_EQ(*BoundaryIou(Square(100, 3, 3, 9), empty), 0);
  EXPECT_EQ(*BoundaryIou(ImageU8(0, 0, 1), ImageU8(0, 0, 1)), 0);
}

TEST(BoundaryIou, RefusesWhatIsNoPairOfMasks) {
  EXPECT_FALSE(BoundaryIou(ImageU8(4, 3, 1), ImageU8(3, 4, 1)).ok());
  EXPECT_FALSE(BoundaryIou(ImageU8(4, 3, 3), ImageU8(4, 3, 3)).ok());
  EXPECT_FALSE(MaskBoundary(ImageU8(4, 3, 1), 0).ok());
}

}  // namespace
}  // namespace freegs::semantics
