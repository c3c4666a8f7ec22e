// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/patches/shared_pixels.h"

#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

namespace freegs::semantics {
namespace {

TEST(SharedPixelsTest, SumsTheGaussiansOfEachPair) {
  // The third Gaussian is in no patch of the first division, the fourth in none
  // of the second, and nobody sees the last one.
  const std::vector<int32_t> a = {1, 0, -1, 0, 1, 1, 0};
  const std::vector<int32_t> b = {0, 2, 2, -1, 0, 1, 0};
  const std::vector<double> seen = {3, 5, 7, 11, 13, 17, 0};
  const std::vector<SharedPixels> shared = FindSharedPixels(a, b, seen);
  ASSERT_EQ(shared.size(), 3u);
  EXPECT_EQ(shared[0].a, 0);
  EXPECT_EQ(shared[0].b, 2);
  EXPECT_EQ(shared[0].pixels, 5);
  EXPECT_EQ(shared[1].a, 1);
  EXPECT_EQ(shared[1].b, 0);
  EXPECT_EQ(shared[1].pixels, 16);
  EXPECT_EQ(shared[2].a, 1);
  EXPECT_EQ(shared[2].b, 1);
  EXPECT_EQ(shared[2].pixels, 17);

  const PatchPixels pixels = PixelsOfPatches(shared, 3, 3);
  EXPECT_EQ(pixels.of_a, (std::vector<double>{5, 33, 0}));
  EXPECT_EQ(pixels.of_b, (std::vector<double>{16, 17, 5}));
  EXPECT_EQ(pixels.first_of_a, (std::vector<size_t>{0, 1, 3, 3}));
}

TEST(SharedPixelsTest, DivisionsThatAreAlikeAgree) {
  const std::vector<int32_t> a = {0, 0, 1, 1, -1};
  const std::vector<double> seen = {1, 2, 3, 4, 5};
  EXPECT_DOUBLE_EQ(Agreement(a, a, seen), 1);
  // Numbers mean nothing.
  EXPECT_DOUBLE_EQ(Agreement(a, std::vector<int32_t>{7, 7, 2, 2, -1}, seen), 1);
  // The second region falls in two, of 3 and 4 pixels.
  EXPECT_DOUBLE_EQ(Agreement(a, std::vector<int32_t>{0, 0, 1, 2, -1}, seen),
                   (3 * 1.0 + 7 * (4.0 / 7)) / 10);
  // What belongs to nobody agrees with nothing.
  EXPECT_DOUBLE_EQ(Agreement(a, std::vector<int32_t>{0, 0, -1, -1, 1}, seen),
                   0.2);
  // Nor does what belongs to nobody in the first division alone.
  EXPECT_DOUBLE_EQ(Agreement(std::vector<int32_t>{0, 0, -1, -1, -1}, a, seen),
                   0.3);
  EXPECT_EQ(Agreement(a, std::vector<int32_t>(5, -1), seen), 0);
  EXPECT_EQ(Agreement(std::vector<int32_t>(5, -1), a, seen), 0);
  EXPECT_EQ(Agreement({}, {}, {}), 0);
}

}  // namespace
}  // namespace freegs::semantics
