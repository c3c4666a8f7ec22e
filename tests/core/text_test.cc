// SPDX-License-Identifier: BSD-3-Clause

#include "core/text.h"

#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace freegs {
namespace {

TEST(AsciiLowerTest, ChangesLettersOnly) {
  EXPECT_EQ(AsciiLower(".JPeG"), ".jpeg");
  EXPECT_EQ(AsciiLower("[@Z`z{\xc4"), "[@z`z{\xc4");
  EXPECT_EQ(AsciiLower(""), "");
}

TEST(TrimmedTest, KeepsBlanksWithin) {
  EXPECT_EQ(Trimmed(" \t a b \r\n"), "a b");
  EXPECT_EQ(Trimmed("a"), "a");
  EXPECT_EQ(Trimmed(" \n"), "");
  EXPECT_EQ(Trimmed(""), "");
}

TEST(WithoutByteOrderMarkTest, DropsOneMarkInFront) {
  EXPECT_EQ(WithoutByteOrderMark("\xef\xbb\xbf"
                                 "a\xef\xbb\xbf"),
            "a\xef\xbb\xbf");
  EXPECT_EQ(WithoutByteOrderMark("\xef\xbb"), "\xef\xbb");
  EXPECT_EQ(WithoutByteOrderMark(""), "");
}

TEST(JoinedTest, PutsCommasBetween) {
  EXPECT_EQ(Joined({}), "");
  EXPECT_EQ(Joined({"a"}), "a");
  EXPECT_EQ(Joined({"a", "b", "c"}), "a, b, c");
}

TEST(SomeNamesTest, CutsLongLists) {
  EXPECT_EQ(SomeNames({}), "");
  EXPECT_EQ(SomeNames({"a"}), "a");
  EXPECT_EQ(SomeNames({"a", "b", "c"}), "a, b and c");
  EXPECT_EQ(SomeNames({"a", "b", "c", "d", "e"}), "a, b, c, d and e");
  EXPECT_EQ(SomeNames({"a", "b", "c", "d", "e", "f"}), "a, b, c, d and 2 more");
  EXPECT_EQ(SomeNames({"a", "b"}, 1), "a and b");
  EXPECT_EQ(SomeNames({"a", "b", "c"}, 1), "a and 2 more");
}

TEST(PercentCodingTest, DecodesWhatItEncodes) {
  std::string all;
  for (int byte = 0; byte < 256; ++byte) all += static_cast<char>(byte);
  const std::string encoded =
      PercentEncode(all, [](char c) { return c >= 'a' && c <= 'z'; });
  EXPECT_TRUE(encoded.starts_with("%00%01%02"));
  EXPECT_TRUE(encoded.ends_with("%FD%FE%FF"));
  EXPECT_EQ(encoded.size(), 26u + 3 * 230);
  EXPECT_EQ(PercentDecode(encoded), all);
  EXPECT_EQ(PercentDecode("caf%e9%E9"), "caf\xe9\xe9");
}

TEST(PercentCodingTest, RefusesWhatIsNoCode) {
  for (const char* text : {"%", "a%4", "%4x", "%x4", "%+4", "%-1", "% 4"}) {
    EXPECT_EQ(PercentDecode(text), std::nullopt) << text;
  }
}

TEST(ShellWordTest, QuotesWhatAShellWouldTakeApart) {
  EXPECT_EQ(ShellWord("/home/a/scene-1.x"), "/home/a/scene-1.x");
  EXPECT_EQ(ShellWord("my scene"), "'my scene'");
  EXPECT_EQ(ShellWord("it's $1"), "'it'\\''s $1'");
  EXPECT_EQ(ShellWord(""), "''");
}

TEST(NaturalLessTest, CountsAsPeopleDo) {
  const std::vector<std::string> ordered = {"a/img2.jpg",
                                            "a/img10.jpg",
                                            "a b/img1.jpg",
                                            "img.jpg",
                                            "img1.jpg",
                                            "img01.jpg",
                                            "img002.jpg",
                                            "img2a.jpg",
                                            "img10.jpg",
                                            "img99999999999999999999.jpg",
                                            "img100000000000000000000.jpg",
                                            "imga.jpg"};
  for (size_t i = 0; i < ordered.size(); ++i) {
    for (size_t j = 0; j < ordered.size(); ++j) {
      if (ordered[i] == "img1.jpg" && ordered[j] == "img01.jpg") continue;
      if (ordered[i] == "img01.jpg" && ordered[j] == "img1.jpg") continue;
      EXPECT_EQ(NaturalLess(ordered[i], ordered[j]), i < j)
          << ordered[i] << " " << ordered[j];
    }
  }
  EXPECT_NE(NaturalLess("img1.jpg", "img01.jpg"),
            NaturalLess("img01.jpg", "img1.jpg"));
}

}  // namespace
}  // namespace freegs
