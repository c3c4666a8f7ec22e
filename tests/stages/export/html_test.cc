// SPDX-License-Identifier: BSD-3-Clause

#include "stages/export/html.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "core/number_text.h"

namespace freegs::stages {
namespace {

TEST(HtmlTest, EscapesMarkupControlsAndBadUtf8) {
  EXPECT_EQ(EscapeHtml("<a href=\"x\">&'"),
            "&lt;a href=&quot;x&quot;&gt;&amp;&#39;");
  EXPECT_EQ(EscapeHtml("gr\u00fcn\n"), "gr\u00fcn\n");
  EXPECT_EQ(EscapeHtml(std::string("a\0b\x1b", 4)), "a\ufffdb\ufffd");
  EXPECT_EQ(EscapeHtml("a\xff"), "a\ufffd");
}

TEST(HtmlTest, EncodesPaths) {
  EXPECT_EQ(EncodeUrlPath("views/1_photo.jpg"), "views/1_photo.jpg");
  EXPECT_EQ(EncodeUrlPath("javascript:a b\"#?%"),
            "javascript%3Aa%20b%22%23%3F%25");
  EXPECT_EQ(EncodeUrlPath("\xff"), "%FF");
}

TEST(HtmlTest, Numbers) {
  EXPECT_EQ(FormatFixed(26.125, 1), "26.1");
  EXPECT_EQ(FormatFixed(std::nan(""), 1), "\u2013");
  EXPECT_EQ(FormatFixed(std::numeric_limits<double>::max(), 2).size(), 312u);
  EXPECT_EQ(FormatCount(7), "7");
  EXPECT_EQ(FormatCount(999), "999");
  EXPECT_EQ(FormatCount(1000), "1,000");
  EXPECT_EQ(FormatCount(-123456), "-123,456");
  EXPECT_EQ(FormatCount(1234567), "1,234,567");
}

TEST(HtmlTest, Durations) {
  EXPECT_EQ(FormatSeconds(1.44), "1.4 s");
  EXPECT_EQ(FormatSeconds(9.96), "10 s");
  EXPECT_EQ(FormatSeconds(59.6), "1 min 00 s");
  EXPECT_EQ(FormatSeconds(185), "3 min 05 s");
  EXPECT_EQ(FormatSeconds(3720), "1 h 02 min");
  EXPECT_EQ(FormatSeconds(-1), "\u2013");
  EXPECT_EQ(FormatSeconds(std::numeric_limits<double>::infinity()), "\u2013");
}

TEST(HtmlTest, Sizes) {
  EXPECT_EQ(FormatBytes(0), "0 B");
  EXPECT_EQ(FormatBytes(812), "812 B");
  EXPECT_EQ(FormatBytes(1440000), "1.4 MB");
  EXPECT_EQ(FormatBytes(123456789), "123 MB");
}

}  // namespace
}  // namespace freegs::stages
