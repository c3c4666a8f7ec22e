// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/clip/caption_text.h"

#include <algorithm>
#include <cstdint>
#include <iterator>

#include "semantics/clip/unicode_text.h"

namespace freegs::semantics {
namespace {

struct NamedReference {
  std::u32string_view name;
  char32_t value;
};

constexpr NamedReference kNamedReferences[] = {{U"amp", U'&'},
                                               {U"lt", U'<'},
                                               {U"gt", U'>'},
                                               {U"quot", U'"'},
                                               {U"apos", U'\''},
                                               {U"nbsp", 0xA0}};

// HTML reads the numbers 0x80 .. 0x9F as Windows-1252, except the five that
// Windows-1252 does not use.
constexpr char32_t kWindows1252[] = {
    0x20AC, 0x81,   0x201A, 0x0192, 0x201E, 0x2026, 0x2020, 0x2021,
    0x02C6, 0x2030, 0x0160, 0x2039, 0x0152, 0x8D,   0x017D, 0x8F,
    0x90,   0x2018, 0x2019, 0x201C, 0x201D, 0x2022, 0x2013, 0x2014,
    0x02DC, 0x2122, 0x0161, 0x203A, 0x0153, 0x9D,   0x017E, 0x0178};

constexpr std::u32string_view kContractions[] = {
    U"'s", U"'t", U"'re", U"'ve", U"'m", U"'ll", U"'d"};

int DigitValue(char32_t c, int base) {
  int value = base;
  if (c >= U'0' && c <= U'9') value = static_cast<int>(c - U'0');
  if (c >= U'a' && c <= U'f') value = static_cast<int>(c - U'a') + 10;
  if (c >= U'A' && c <= U'F') value = static_cast<int>(c - U'A') + 10;
  return value < base ? value : -1;
}

bool IsAlphanumeric(char32_t c) {
  return DigitValue(c, 10) >= 0 || (c >= U'a' && c <= U'z') ||
         (c >= U'A' && c <= U'Z');
}

// Appends what the number stands for by HTML's rules; some stand for nothing.
void AppendNumbered(uint32_t number, std::u32string* result) {
  if (number >= 0x80 && number <= 0x9F) {
    result->push_back(kWindows1252[number - 0x80]);
  } else if (number == 0 || number > 0x10FFFF ||
             (number >= 0xD800 && number <= 0xDFFF)) {
    result->push_back(0xFFFD);
  } else if (number == 0x0D ||
             !(number <= 0x08 || (number >= 0x0E && number <= 0x1F) ||
               number == 0x0B || number == 0x7F ||
               (number >= 0xFDD0 && number <= 0xFDEF) ||
               (number & 0xFFFE) == 0xFFFE)) {
    result->push_back(number);
  }
}

// The reference that begins with the '&' at text[i]: appends its value and
// returns its length, or 0 if there is none.
size_t ResolveReference(std::u32string_view text,
                        size_t i,
                        std::u32string* result) {
  size_t end = i + 1;
  const auto past_semicolon = [&text](size_t at) {
    return at < text.size() && text[at] == U';' ? at + 1 : at;
  };
  if (end < text.size() && text[end] == U'#') {
    ++end;
    int base = 10;
    if (end < text.size() && (text[end] == U'x' || text[end] == U'X')) {
      base = 16;
      ++end;
    }
    const size_t first_digit = end;
    uint32_t number = 0;
    for (; end < text.size() && DigitValue(text[end], base) >= 0; ++end) {
      // Beyond the largest code point all numbers are alike.
      number = std::min<uint32_t>(number * base + DigitValue(text[end], base),
                                  0x110000);
    }
    if (end == first_digit) return 0;
    AppendNumbered(number, result);
    return past_semicolon(end) - i;
  }
  while (end < text.size() && IsAlphanumeric(text[end])) ++end;
  const std::u32string_view name = text.substr(i + 1, end - i - 1);
  for (const NamedReference& known : kNamedReferences) {
    if (known.name != name) continue;
    result->push_back(known.value);
    return past_semicolon(end) - i;
  }
  return 0;
}

std::u32string ResolveReferences(std::u32string_view text) {
  std::u32string result;
  for (size_t i = 0; i < text.size();) {
    const size_t length =
        text[i] == U'&' ? ResolveReference(text, i, &result) : 0;
    if (length == 0) result.push_back(text[i]);
    i += std::max<size_t>(1, length);
  }
  return result;
}

// For str.strip() of Python four control characters are white space that are
// none in regular expressions.
bool IsStripped(char32_t c) {
  return IsWhiteSpace(c) || (c >= 0x1C && c <= 0x1F);
}

std::u32string_view Trim(std::u32string_view text) {
  while (!text.empty() && IsStripped(text.front())) text.remove_prefix(1);
  while (!text.empty() && IsStripped(text.back())) text.remove_suffix(1);
  return text;
}

bool BeginsWith(std::u32string_view text, std::u32string_view words) {
  return text.size() >= words.size() &&
         std::equal(
             words.begin(), words.end(), text.begin(), [](char32_t w, auto t) {
               // The reference ignores case: the long s counts as an s.
               return w == t || (w == U's' && t == 0x17F);
             });
}

// Characters that the expression of the reference matches nowhere: white space
// and the combining iota. The latter is due to ignoring case, since its capital
// is iota.
bool IsSeparator(char32_t c) { return IsWhiteSpace(c) || c == 0x345; }

size_t LengthOfFirst(std::u32string_view text) {
  for (const std::u32string_view special : {kStartOfText, kEndOfText}) {
    if (BeginsWith(text, special)) return special.size();
  }
  for (const std::u32string_view contraction : kContractions) {
    if (BeginsWith(text, contraction)) return contraction.size();
  }
  if (IsNumber(text[0])) return 1;
  const bool letters = IsLetter(text[0]);
  const auto end = std::find_if(text.begin(), text.end(), [&](char32_t c) {
    return letters ? !IsLetter(c)
                   : IsLetter(c) || IsNumber(c) || IsSeparator(c);
  });
  return static_cast<size_t>(end - text.begin());
}

}  // namespace

std::u32string CleanCaption(std::u32string_view text) {
  const std::u32string resolved = ResolveReferences(ResolveReferences(text));
  std::u32string collapsed;
  bool pending_space = false;
  for (const char32_t c : Trim(resolved)) {
    if (IsWhiteSpace(c)) {
      pending_space = true;
      continue;
    }
    if (pending_space) collapsed.push_back(U' ');
    pending_space = false;
    collapsed.push_back(c);
  }
  return LowerCase(Trim(collapsed));
}

std::vector<std::u32string_view> SplitCaption(std::u32string_view text) {
  std::vector<std::u32string_view> words;
  while (!text.empty()) {
    if (IsSeparator(text[0])) {
      text.remove_prefix(1);
      continue;
    }
    const size_t length = LengthOfFirst(text);
    words.push_back(text.substr(0, length));
    text.remove_prefix(length);
  }
  return words;
}

}  // namespace freegs::semantics
