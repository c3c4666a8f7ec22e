// SPDX-License-Identifier: BSD-3-Clause

#include "stages/reconstruct/training_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace freegs::stages {
namespace {

TEST(DisplacementNoteTest, HalfOfThePhotosMayLieAnywhere) {
  EXPECT_EQ(DisplacementNote({}), "");
  EXPECT_EQ(DisplacementNote({{0.2, 800}, {0.5, 800}, {60, 800}}), "");
  EXPECT_EQ(DisplacementNote({{3.9, 800}}), "");
  EXPECT_EQ(DisplacementNote({{1.4, 80}}), "");
  EXPECT_THAT(DisplacementNote({{0.2, 320}, {3, 320}, {5, 320}}),
              testing::HasSubstr("2 of 3 photos"));
  EXPECT_THAT(DisplacementNote({{0.2, 320}, {3, 320}, {5, 320}}),
              testing::HasSubstr("by 3.0 pixels"));
}

}  // namespace
}  // namespace freegs::stages
