// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/clip/unicode_text.h"

#include <gtest/gtest.h>

namespace freegs::semantics {
namespace {

TEST(UnicodeTextTest, EveryCodePointComesBack) {
  std::u32string all;
  for (char32_t c = 0; c <= 0x10FFFF; ++c) {
    if (c < 0xD800 || c > 0xDFFF) all.push_back(c);
  }
  EXPECT_EQ(DecodeUtf8(EncodeUtf8(all)), all);
}

TEST(UnicodeTextTest, InvalidBytesAreReplaced) {
  for (const char* bytes : {"\x80",
                            "\xff",
                            "\xc3",
                            "\xc0\xaf",          // Overlong.
                            "\xe0\x80\x80",      // Overlong.
                            "\xf0\x80\x80\x80",  // Overlong.
                            "\xed\xa0\x80",      // Surrogate.
                            "\xf4\x90\x80\x80",  // Past U+10FFFF.
                            "\xe2\x82",          // Truncated.
                            "\xf8\x88\x80\x80\x80"}) {
    const std::u32string text = DecodeUtf8(bytes);
    EXPECT_EQ(text, std::u32string(std::string_view(bytes).size(), 0xFFFD));
  }
  EXPECT_EQ(DecodeUtf8("a\xffz"), U"a\uFFFDz");
  EXPECT_EQ(EncodeUtf8(std::u32string(1, 0xD800)), "\xEF\xBF\xBD");
  EXPECT_EQ(EncodeUtf8(std::u32string(1, 0xFFFFFFFF)), "\xEF\xBF\xBD");
}

TEST(UnicodeTextTest, LettersNumbersAndWhiteSpaceAreToldApart) {
  const std::u32string letters =
      U"azAZ\u00b5\u00e9\u03a9\u0436\u4e2d\uac00\u0e01";
  for (const char32_t c : letters) {
    EXPECT_TRUE(IsLetter(c)) << static_cast<uint32_t>(c);
  }
  for (const char32_t c : {U'1', U'\u00bd', U'\u00b2', U'\uff11', U'\u0663'}) {
    EXPECT_TRUE(IsNumber(c)) << static_cast<uint32_t>(c);
    EXPECT_FALSE(IsLetter(c)) << static_cast<uint32_t>(c);
  }
  for (const char32_t c : {U'\0', U'_', U'\u0301', U'\U0001F34E', U'\u200b'}) {
    EXPECT_FALSE(IsLetter(c) || IsNumber(c) || IsWhiteSpace(c));
  }
  EXPECT_TRUE(IsWhiteSpace(0xA0));
  EXPECT_FALSE(IsLetter(0xFFFFFFFF));
}

TEST(UnicodeTextTest, LowerCase) {
  EXPECT_EQ(LowerCase(U"MiXeD 42!"), U"mixed 42!");
  EXPECT_EQ(LowerCase(U"\u00dcBER \u0141\u00d3D\u0179"),
            U"\u00fcber \u0142\u00f3d\u017a");
  EXPECT_EQ(LowerCase(U"\u0130"), U"i\u0307");
  // Latin letters that alternate between capital and small, and a far one.
  EXPECT_EQ(LowerCase(U"\u0100\u0101\u0102\u1e9e\u2126\U00010400"),
            U"\u0101\u0101\u0103\u00df\u03c9\U00010428");
}

TEST(UnicodeTextTest, SigmaHasAFinalForm) {
  EXPECT_EQ(LowerCase(U"\u039f\u0394\u039f\u03a3 \u03a3\u0391"),
            U"\u03bf\u03b4\u03bf\u03c2 \u03c3\u03b1");
  EXPECT_EQ(LowerCase(U"\u03a3"), U"\u03c3");
  // An apostrophe is skipped when looking for neighbours.
  EXPECT_EQ(LowerCase(U"\u0391'\u03a3'"), U"\u03b1'\u03c2'");
  EXPECT_EQ(LowerCase(U"\u0391\u03a3'\u0391"), U"\u03b1\u03c3'\u03b1");
}

}  // namespace
}  // namespace freegs::semantics
