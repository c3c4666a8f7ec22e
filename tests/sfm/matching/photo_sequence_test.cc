// SPDX-License-Identifier: BSD-3-Clause

#include "sfm/matching/photo_sequence.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace freegs::sfm {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

TEST(PhotoSequence, NumbersInOrderOfValue) {
  EXPECT_THAT(
      FindNumberedPhotos({"f10.jpg", "f9.jpg", "f0011.jpg", "f8.jpg"}, 3),
      ElementsAre(ElementsAre(3, 1, 0, 2)));
}

TEST(PhotoSequence, LeftmostNumberFirst) {
  EXPECT_THAT(FindNumberedPhotos({"VID_20240101_235959_1080p.jpg",
                                  "VID_20240102_000001_1080p.jpg",
                                  "VID_20240101_235958_1080p.jpg"},
                                 3),
              ElementsAre(ElementsAre(2, 0, 1)));
}

TEST(PhotoSequence, PatternsAreApart) {
  EXPECT_THAT(FindNumberedPhotos({"a1.jpg",
                                  "b/1.png",
                                  "b/2.png",
                                  "a2.jpg",
                                  "plain.jpg",
                                  "a3.JPG",
                                  "b/3.png"},
                                 2),
              ElementsAre(ElementsAre(1, 2, 6), ElementsAre(0, 3)));
}

TEST(PhotoSequence, OddNames) {
  EXPECT_THAT(FindNumberedPhotos({}, 1), IsEmpty());
  EXPECT_THAT(FindNumberedPhotos({"", "x", "_"}, 1), IsEmpty());
  const std::string zeros(500, '0');
  const std::string nines(500, '9');
  EXPECT_THAT(FindNumberedPhotos({nines, "1" + nines, zeros, "7"}, 2),
              ElementsAre(ElementsAre(2, 3, 0, 1)));
  // Equal numbers keep the order given.
  EXPECT_THAT(FindNumberedPhotos({"01", "1", "001"}, 2),
              ElementsAre(ElementsAre(0, 1, 2)));
}

}  // namespace
}  // namespace freegs::sfm
