// SPDX-License-Identifier: BSD-3-Clause

#include "stages/run/duration.h"

#include <string>

#include <gtest/gtest.h>

namespace freegs::stages {
namespace {

TEST(Duration, IsReadAsPeopleWriteIt) {
  EXPECT_EQ(*ParseDuration("90"), 90);
  EXPECT_EQ(*ParseDuration("90s"), 90);
  EXPECT_EQ(*ParseDuration("5m"), 300);
  EXPECT_EQ(*ParseDuration("2.5m"), 150);
  EXPECT_EQ(*ParseDuration("1h"), 3600);
  EXPECT_EQ(*ParseDuration("1h30m"), 5400);
  EXPECT_EQ(*ParseDuration("1h0m5s"), 3605);
}

TEST(Duration, OthersAreErrors) {
  for (const std::string text :
       {"",     "m",    "5 m",  "5d",  "-5m",   "+5",  "0",
        "0m",   "5m1h", "5m5m", "5m5", "1e3",   "nan", "inf",
        "0x10", "5mm",  "h5",   ".5m", "1..5m", "5m ", "99999h"}) {
    const StatusOr<double> seconds = ParseDuration(text);
    ASSERT_FALSE(seconds.ok()) << text;
    EXPECT_EQ(seconds.status().code(), StatusCode::kInvalidArgument) << text;
  }
  EXPECT_FALSE(ParseDuration(std::string(100000, '9')).ok());
  EXPECT_FALSE(ParseDuration(std::string("5m\0", 3)).ok());
}

}  // namespace
}  // namespace freegs::stages
