// SPDX-License-Identifier: BSD-3-Clause

#include "core/number_text.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace freegs {
namespace {

constexpr double kInfiniteNumber = std::numeric_limits<double>::infinity();

TEST(NumberTextTest, RoundsNumbersAndShowsADashWhereThereIsNone) {
  EXPECT_EQ(FormatFixed(26.125, 1), "26.1");
  EXPECT_EQ(FormatFixed(-0.5, 2), "-0.50");
  EXPECT_EQ(FormatFixed(std::nan(""), 1), "\u2013");
  EXPECT_EQ(FormatFixed(std::numeric_limits<double>::max(), 2).size(), 312u);
  EXPECT_EQ(FormatSignificant(0.0034567, 3), "0.00346");
  EXPECT_EQ(FormatSignificant(400, 6), "400");
  EXPECT_EQ(FormatSignificant(1500.5, 6), "1500.5");
  EXPECT_EQ(FormatSignificant(1e12, 6), "1e+12");
  EXPECT_EQ(FormatSignificant(kInfiniteNumber, 3), "\u2013");
  EXPECT_EQ(FormatPercent(0.834), "83 %");
  EXPECT_EQ(FormatPercent(0.125), "13 %");
  EXPECT_EQ(FormatPercent(-1), "-100 %");
  EXPECT_EQ(FormatPercent(std::nan("")), "\u2013");
  EXPECT_EQ(FormatPercent(1e300), "\u2013");
}

TEST(NumberTextTest, ShowsMoreDigitsOfWhatWouldLookLikeALimit) {
  EXPECT_EQ(DecimalsApart(26.96, 27, 1), 2);
  EXPECT_EQ(DecimalsApart(26.9, 27, 1), 1);
  EXPECT_EQ(DecimalsApart(26.9999996, 27, 1), 4);
}

TEST(NumberTextTest, DecimalsShowThreeDigits) {
  EXPECT_EQ(DecimalsFor(1.5), 2);
  EXPECT_EQ(DecimalsFor(0.0015), 5);
  EXPECT_EQ(DecimalsFor(100), 0);
  EXPECT_EQ(DecimalsFor(1e9), 0);
  EXPECT_EQ(DecimalsFor(1e-30), 12);
  EXPECT_EQ(DecimalsFor(0), 3);
  EXPECT_EQ(DecimalsFor(-1), 3);
  EXPECT_EQ(DecimalsFor(kInfiniteNumber), 3);
  EXPECT_EQ(DecimalsFor(std::nan("")), 3);
}

TEST(NumberTextTest, CountsHaveCommasBetweenThousands) {
  EXPECT_EQ(FormatCount(7), "7");
  EXPECT_EQ(FormatCount(999), "999");
  EXPECT_EQ(FormatCount(1000), "1,000");
  EXPECT_EQ(FormatCount(-123456), "-123,456");
  EXPECT_EQ(FormatCount(1234567), "1,234,567");
}

TEST(NumberTextTest, LongDurationsHaveLargerUnits) {
  EXPECT_EQ(FormatSeconds(0), "0.0 s");
  EXPECT_EQ(FormatSeconds(1.44), "1.4 s");
  EXPECT_EQ(FormatSeconds(9.94), "9.9 s");
  EXPECT_EQ(FormatSeconds(9.96), "10 s");
  EXPECT_EQ(FormatSeconds(59.4), "59 s");
  EXPECT_EQ(FormatSeconds(59.6), "1 min 00 s");
  EXPECT_EQ(FormatSeconds(185), "3 min 05 s");
  EXPECT_EQ(FormatSeconds(3725), "1 h 02 min");
  EXPECT_EQ(FormatSeconds(1e12), "over 30 years");
  EXPECT_EQ(FormatSeconds(-1), "\u2013");
  EXPECT_EQ(FormatSeconds(std::nan("")), "\u2013");
  EXPECT_EQ(FormatSeconds(kInfiniteNumber), "\u2013");
}

TEST(NumberTextTest, LargeSizesHaveLargerUnits) {
  EXPECT_EQ(FormatBytes(0), "0 B");
  EXPECT_EQ(FormatBytes(812), "812 B");
  EXPECT_EQ(FormatBytes(1440000), "1.4 MB");
  EXPECT_EQ(FormatBytes(123456789), "123 MB");
  EXPECT_EQ(FormatBytes(-1), "\u2013");
}

}  // namespace
}  // namespace freegs
