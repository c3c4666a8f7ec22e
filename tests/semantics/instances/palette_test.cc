// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/instances/palette.h"

#include <cstdlib>
#include <set>

#include <gtest/gtest.h>

namespace freegs::semantics {
namespace {

TEST(PaletteTest, FirstHundredColoursDiffer) {
  std::set<std::array<uint8_t, 3>> colors = {PaletteColor(-1)};
  for (int label = 0; label < 100; ++label) {
    EXPECT_TRUE(colors.insert(PaletteColor(label)).second) << label;
  }
}

TEST(PaletteTest, NeighboursDifferStrongly) {
  for (int label = 0; label < 200; ++label) {
    const auto a = PaletteColor(label);
    const auto b = PaletteColor(label + 1);
    int difference = 0;
    for (int k = 0; k < 3; ++k) difference += std::abs(a[k] - b[k]);
    EXPECT_GT(difference, 80) << label;
  }
}

TEST(PaletteTest, NoLabelIsGrey) {
  EXPECT_EQ(PaletteColor(-1), PaletteColor(-7));
  const auto grey = PaletteColor(-1);
  EXPECT_EQ(grey[0], grey[1]);
  EXPECT_EQ(grey[1], grey[2]);
}

}  // namespace
}  // namespace freegs::semantics
