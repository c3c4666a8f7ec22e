// SPDX-License-Identifier: BSD-3-Clause

#include "stages/disturb/disturbance.h"

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace freegs::stages {
namespace {

using ::testing::HasSubstr;

TEST(DisturbanceTest, NamesAndAmountsAreRead) {
  const auto noise = ParseDisturbance("noise:8.5");
  ASSERT_TRUE(noise.ok()) << noise.status().message();
  EXPECT_EQ(*noise, (Disturbance{DisturbanceKind::kNoise, 8.5}));
  EXPECT_EQ(ParseDisturbance("shuffle")->kind, DisturbanceKind::kShuffle);
  EXPECT_EQ(ParseDisturbance("none")->kind, DisturbanceKind::kNone);
  EXPECT_EQ(ParseDisturbance("scale:1e-3")->amount, 1e-3);
  EXPECT_EQ(ParseDisturbance("exposure:-2")->amount, -2);
  EXPECT_TRUE(ParseDisturbance("move:1e6")->ChangesPoses());
  EXPECT_FALSE(ParseDisturbance("mover:0.2")->ChangesPoses());
}

TEST(DisturbanceTest, FaultsSayWhatThereIs) {
  const auto message = [](const std::string& text) {
    const auto read = ParseDisturbance(text);
    EXPECT_EQ(read.status().code(), StatusCode::kInvalidArgument) << text;
    return read.status().message();
  };
  EXPECT_THAT(message("noises:8"), HasSubstr("noise:SIGMA, blur:PIXELS"));
  EXPECT_THAT(message(""), HasSubstr("there are none"));
  EXPECT_THAT(message("noise"), HasSubstr("a number from 0 to 255"));
  for (const char* text : {"noise:",
                           "noise:x",
                           "noise:8x",
                           "noise:nan",
                           "noise:inf",
                           "noise:-1",
                           "noise:256",
                           "noise:8:8"}) {
    EXPECT_THAT(message(text), HasSubstr("noise:SIGMA")) << text;
  }
  EXPECT_THAT(message("jpeg:30.5"), HasSubstr("a whole number from 1 to 100"));
  EXPECT_THAT(message("shuffle:3"), HasSubstr("just shuffle"));
}

}  // namespace
}  // namespace freegs::stages
