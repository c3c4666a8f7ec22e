// SPDX-License-Identifier: BSD-3-Clause

#include "stages/export/label_masks.h"

#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/random.h"

namespace freegs::stages {
namespace {

using testing::ElementsAre;

Image<int32_t> LabelPicture(int width,
                            int height,
                            const std::vector<int32_t>& values) {
  Image<int32_t> picture(width, height, 1);
  std::copy(values.begin(), values.end(), picture.data());
  return picture;
}

// The inverse of CompressRuns, written for itself.
std::vector<uint32_t> DecompressRuns(const std::string& text) {
  std::vector<uint32_t> runs;
  for (size_t at = 0; at < text.size();) {
    int64_t value = 0;
    int shift = 0;
    bool more = true;
    while (more) {
      const int64_t c = text[at++] - '0';
      value |= (c & 31) << shift;
      shift += 5;
      more = (c & 32) != 0;
      if (!more && (c & 16) != 0) value -= int64_t{1} << shift;
    }
    if (runs.size() > 2) value += runs[runs.size() - 2];
    runs.push_back(static_cast<uint32_t>(value));
  }
  return runs;
}

TEST(LabelMasksTest, RunsGoDownTheColumns) {
  const auto masks = MasksOfLabels(LabelPicture(4,
                                                3,
                                                {0,
                                                 -1,
                                                 5,
                                                 5,  //
                                                 0,
                                                 0,
                                                 5,
                                                 -1,  //
                                                 5,
                                                 0,
                                                 5,
                                                 -1}));
  ASSERT_EQ(masks.size(), 2u);
  const LabelMask& zero = masks.at(0);
  EXPECT_THAT(zero.runs, ElementsAre(0, 2, 2, 2, 6));
  EXPECT_EQ(zero.area, 4);
  EXPECT_EQ(zero.left, 0);
  EXPECT_EQ(zero.top, 0);
  EXPECT_EQ(zero.right, 2);
  EXPECT_EQ(zero.bottom, 3);
  // The last four pixels go over from one column to the next.
  const LabelMask& five = masks.at(5);
  EXPECT_THAT(five.runs, ElementsAre(2, 1, 3, 4, 2));
  EXPECT_EQ(five.area, 5);
  EXPECT_EQ(five.left, 0);
  EXPECT_EQ(five.top, 0);
  EXPECT_EQ(five.right, 4);
}

TEST(LabelMasksTest, BoxOfASinglePixel) {
  const auto masks = MasksOfLabels(LabelPicture(2, 3, {-1, -1, -1, 7, -1, -1}));
  const LabelMask& mask = masks.at(7);
  EXPECT_THAT(mask.runs, ElementsAre(4, 1, 1));
  EXPECT_EQ(mask.left, 1);
  EXPECT_EQ(mask.top, 1);
  EXPECT_EQ(mask.right, 2);
  EXPECT_EQ(mask.bottom, 2);
}

TEST(LabelMasksTest, WholePictureAndNothing) {
  EXPECT_THAT(MasksOfLabels(LabelPicture(2, 2, {1, 1, 1, 1})).at(1).runs,
              ElementsAre(0, 4));
  EXPECT_TRUE(MasksOfLabels(LabelPicture(2, 1, {-1, -1})).empty());
}

// By hand: 3 is '3', 0 is '0'; 40 is 8 + 32 and then 1; 16 needs a second
// character, as its fifth bit would be a sign; 4 - 40 = -36 is 28 and then -2.
TEST(LabelMasksTest, CompressedText) {
  EXPECT_EQ(CompressRuns(std::vector<uint32_t>{}), "");
  EXPECT_EQ(CompressRuns(std::vector<uint32_t>{3, 0, 15}), "30?");
  EXPECT_EQ(CompressRuns(std::vector<uint32_t>{16}), "`0");
  EXPECT_EQ(CompressRuns(std::vector<uint32_t>{0, 40, 3, 4}), "0X13lN");
}

TEST(LabelMasksTest, MasksReadBack) {
  const int width = 37;
  const int height = 23;
  Image<int32_t> picture(width, height, 1);
  for (size_t k = 0; k < picture.size(); ++k) {
    picture.data()[k] =
        static_cast<int32_t>(5 * RandomUniform(1, 2, k / 6)) - 1;
  }
  for (const auto& [label, mask] : MasksOfLabels(picture)) {
    const std::vector<uint32_t> runs = DecompressRuns(CompressRuns(mask.runs));
    ASSERT_EQ(runs, mask.runs);
    size_t at = 0;
    int64_t area = 0;
    bool inside = false;
    for (const uint32_t run : runs) {
      for (uint32_t k = 0; k < run; ++k, ++at) {
        const int x = static_cast<int>(at) / height;
        const int y = static_cast<int>(at) % height;
        EXPECT_EQ(picture(x, y) == label, inside);
        if (!inside) continue;
        ++area;
        EXPECT_TRUE(x >= mask.left && x < mask.right);
        EXPECT_TRUE(y >= mask.top && y < mask.bottom);
      }
      inside = !inside;
    }
    EXPECT_EQ(at, picture.size());
    EXPECT_EQ(area, mask.area);
  }
}

}  // namespace
}  // namespace freegs::stages
