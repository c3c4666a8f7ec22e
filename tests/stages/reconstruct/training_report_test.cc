// SPDX-License-Identifier: BSD-3-Clause

#include "stages/reconstruct/training_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace freegs::stages {
namespace {

TEST(DisplacementNoteTest, HalfOfThePhotosMayLieAnywhere) {
  const auto note = [](const std::vector<DisplacedView>& views) {
    return DisplacementNote(views, /*imported_scene=*/false);
  };
  EXPECT_EQ(note({}), "");
  EXPECT_EQ(note({{0.2, 800}, {0.5, 800}, {60, 800}}), "");
  EXPECT_EQ(note({{3.9, 800}}), "");
  EXPECT_EQ(note({{1.4, 80}}), "");
  const std::vector<DisplacedView> far = {{0.2, 320}, {3, 320}, {5, 320}};
  EXPECT_THAT(note(far), testing::HasSubstr("2 of 3 photos"));
  EXPECT_THAT(note(far), testing::HasSubstr("by 3.0 pixels"));
  EXPECT_THAT(note(far), testing::HasSubstr("without sfm.import"));
  EXPECT_THAT(DisplacementNote(far, /*imported_scene=*/true),
              testing::HasSubstr("import those, too"));
}

TEST(ExposureTextTest, SaysWhatTheTrialShowed) {
  EXPECT_THAT(ExposureText(std::nullopt), testing::HasSubstr("the time is up"));
  splat::ExposureChoice choice;
  EXPECT_THAT(ExposureText(choice),
              testing::AllOf(testing::HasSubstr("photos are too few"),
                             testing::HasSubstr("came to nothing")));
  choice.without = {.trained = 21, .held_out = 0};
  choice.with = {.trained = 23, .held_out = 0};
  EXPECT_THAT(ExposureText(choice),
              testing::AllOf(testing::HasSubstr("masks leave too little"),
                             testing::Not(testing::HasSubstr("dB"))));
  choice.learn = true;
  choice.without = {.trained = 21, .held_out = 20.5};
  choice.with = {.trained = 23, .held_out = 22.25};
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
