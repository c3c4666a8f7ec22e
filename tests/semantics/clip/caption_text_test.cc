// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/clip/caption_text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace freegs::semantics {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

TEST(CaptionTextTest, WhiteSpaceIsCollapsedAndTrimmed) {
  EXPECT_EQ(CleanCaption(U" \t A\u00a0\n b \x1c"), U"a b");
  EXPECT_EQ(CleanCaption(U"   "), U"");
  EXPECT_EQ(CleanCaption(U""), U"");
}

TEST(CaptionTextTest, ReferencesAreResolvedTwice) {
  EXPECT_EQ(CleanCaption(U"&amp; &lt;b&gt; &quot &apos;"), U"& <b> \" '");
  EXPECT_EQ(CleanCaption(U"&amp;amp; &amp;lt; x"), U"& < x");
  EXPECT_EQ(CleanCaption(U"&#65;&#x42;&#X43 &#150; &#0;"),
            U"abc \u2013 \uFFFD");
}

TEST(CaptionTextTest, BrokenAndUnknownReferencesStay) {
  for (const std::u32string text : {U"&",
                                    U"a & b",
                                    U"&;",
                                    U"&#;",
                                    U"&#x;",
                                    U"&#xg;",
                                    U"&unknown;",
                                    U"&#",
                                    U"&ampx;"}) {
    EXPECT_EQ(CleanCaption(text), text);
  }
}

TEST(CaptionTextTest, NumbersThatStandForNothing) {
  EXPECT_EQ(CleanCaption(U"a&#1;b&#xfffe;c&#x7f;"), U"abc");
  EXPECT_EQ(CleanCaption(U"&#xd800;&#x110000;&#99999999999999999999999;"),
            U"\uFFFD\uFFFD\uFFFD");
}

TEST(CaptionTextTest, WordsSuffixesAndDigitsAreTokensOfTheirOwn) {
  EXPECT_THAT(
      SplitCaption(U"don't they're 42!?x"),
      ElementsAre(U"don", U"'t", U"they", U"'re", U"4", U"2", U"!?", U"x"));
  EXPECT_THAT(SplitCaption(U"<|startoftext|><|endoftext|>"),
              ElementsAre(kStartOfText, kEndOfText));
  // Only where a word begins.
  EXPECT_THAT(SplitCaption(U"!<|endoftext|>'s"),
              ElementsAre(U"!<|", U"endoftext", U"|>'", U"s"));
  EXPECT_THAT(SplitCaption(U"'\u017f"), ElementsAre(U"'\u017f"));
  EXPECT_THAT(SplitCaption(U"\u0345.\u0345"), ElementsAre(U"."));
  EXPECT_THAT(SplitCaption(U""), IsEmpty());
  EXPECT_THAT(SplitCaption(U" '"), ElementsAre(U"'"));
}

}  // namespace
}  // namespace freegs::semantics
