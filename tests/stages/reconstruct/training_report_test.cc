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

TEST(ExposureTextTest, SaysWhatTheTrialShowed) {
  splat::ExposureChoice choice;
  EXPECT_THAT(ExposureText(choice), testing::HasSubstr("photos are too few"));
  choice.without = {.trained = 21, .others = 0};
  choice.with = {.trained = 23, .others = 0};
  EXPECT_THAT(ExposureText(choice),
              testing::AllOf(testing::HasSubstr("masks leave too little"),
                             testing::Not(testing::HasSubstr("dB"))));
  choice.learn = true;
  choice.without = {.trained = 21, .others = 20.5};
  choice.with = {.trained = 23, .others = 22.25};
  EXPECT_THAT(ExposureText(choice),
              testing::AllOf(testing::HasSubstr("photo is learnt"),
                             testing::HasSubstr("21.00 -> 23.00 dB"),
                             testing::HasSubstr("20.50 -> 22.25 dB")));
}

TEST(NewViewsNoteTest, ErrorsTwiceAsLarge) {
  EXPECT_EQ(NewViewsNote(30, {}), "");
  EXPECT_EQ(NewViewsNote(30, {24.1}), "");
  EXPECT_EQ(NewViewsNote(30, {35, 12, 25}), "");
  EXPECT_EQ(NewViewsNote(25, {31}), "");
  EXPECT_THAT(NewViewsNote(30, {12, 23, 25, 19}),
              testing::HasSubstr("with 21.0 dB (median of 4)"));
  EXPECT_THAT(NewViewsNote(30, {12, 23, 25, 19}),
              testing::HasSubstr("trained on with 30.0 dB"));
}

}  // namespace
}  // namespace freegs::stages
