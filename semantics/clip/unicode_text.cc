// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/clip/unicode_text.h"

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <span>

#include "semantics/clip/unicode_tables.h"

namespace freegs::semantics {
namespace {

constexpr char32_t kReplacement = 0xFFFD;
constexpr char32_t kCapitalSigma = 0x3A3;
constexpr char32_t kSmallSigma = 0x3C3;
constexpr char32_t kFinalSigma = 0x3C2;
constexpr char32_t kCapitalDottedI = 0x130;
constexpr char32_t kCombiningDot = 0x307;

bool IsSurrogate(char32_t c) { return c >= 0xD800 && c <= 0xDFFF; }

// The sorted range that holds c, or null.
template <typename Range>
const Range* FindRange(std::span<const Range> ranges, char32_t c) {
  const auto found = std::lower_bound(
      ranges.begin(), ranges.end(), c, [](const Range& range, char32_t value) {
        return range.last < value;
      });
  return found != ranges.end() && found->first <= c ? &*found : nullptr;
}

bool IsIn(std::span<const unicode_tables::Range> ranges, char32_t c) {
  return FindRange(ranges, c) != nullptr;
}

char32_t Lower(char32_t c) {
  // Ranges with a step interleave, so that several of them can span c.
  for (const unicode_tables::LowerMapping& mapping : unicode_tables::kLower) {
    if (mapping.first > c) break;
    if (c <= mapping.last && (c - mapping.first) % mapping.step == 0) {
      return static_cast<char32_t>(static_cast<int32_t>(c) + mapping.delta);
    }
  }
  return c;
}

// Whether the first character of [begin, end) that is not ignored is a cased
// letter.
template <typename Iterator>
bool FindsCased(Iterator begin, Iterator end) {
  const Iterator found = std::find_if(begin, end, [](char32_t c) {
    return !IsIn(unicode_tables::kCaseIgnorable, c);
  });
  return found != end && IsIn(unicode_tables::kCased, *found);
}

// The code point that begins at text[i] and its length in bytes; 0 if invalid.
int DecodeOne(std::string_view text, size_t i, char32_t* c) {
  const auto byte = [&text](size_t at) {
    return static_cast<uint8_t>(text[at]);
  };
  const uint8_t lead = byte(i);
  int length = 0;
  char32_t smallest = 0;
  if (lead < 0x80) {
    *c = lead;
    return 1;
  }
  if (lead >= 0xC2 && lead <= 0xDF) {
    length = 2;
    smallest = 0x80;
    *c = lead & 0x1F;
  } else if ((lead & 0xF0) == 0xE0) {
    length = 3;
    smallest = 0x800;
    *c = lead & 0x0F;
  } else if (lead >= 0xF0 && lead <= 0xF4) {
    length = 4;
    smallest = 0x10000;
    *c = lead & 0x07;
  } else {
    return 0;
  }
  if (text.size() - i < static_cast<size_t>(length)) return 0;
  for (int k = 1; k < length; ++k) {
    if ((byte(i + k) & 0xC0) != 0x80) return 0;
    *c = *c << 6 | (byte(i + k) & 0x3F);
  }
  return *c < smallest || *c > 0x10FFFF || IsSurrogate(*c) ? 0 : length;
}

}  // namespace

std::u32string DecodeUtf8(std::string_view text) {
  std::u32string result;
  result.reserve(text.size());
  for (size_t i = 0; i < text.size();) {
    char32_t c = 0;
    const int length = DecodeOne(text, i, &c);
    result.push_back(length > 0 ? c : kReplacement);
    i += static_cast<size_t>(std::max(1, length));
  }
  return result;
}

std::string EncodeUtf8(std::u32string_view text) {
  std::string result;
  result.reserve(text.size());
  for (char32_t c : text) {
    if (IsSurrogate(c) || c > 0x10FFFF) c = kReplacement;
    if (c < 0x80) {
      result.push_back(static_cast<char>(c));
      continue;
    }
    const int following = c < 0x800 ? 1 : c < 0x10000 ? 2 : 3;
    constexpr uint32_t kLead[] = {0, 0xC0, 0xE0, 0xF0};
    result.push_back(static_cast<char>(kLead[following] | c >> 6 * following));
    for (int k = following - 1; k >= 0; --k) {
      result.push_back(static_cast<char>(0x80 | (c >> 6 * k & 0x3F)));
    }
  }
  return result;
}

bool IsLetter(char32_t c) { return IsIn(unicode_tables::kLetters, c); }

bool IsNumber(char32_t c) { return IsIn(unicode_tables::kNumbers, c); }

bool IsWhiteSpace(char32_t c) {
  return (c >= 0x9 && c <= 0xD) || c == 0x20 || c == 0x85 || c == 0xA0 ||
         c == 0x1680 || (c >= 0x2000 && c <= 0x200A) || c == 0x2028 ||
         c == 0x2029 || c == 0x202F || c == 0x205F || c == 0x3000;
}

std::u32string LowerCase(std::u32string_view text) {
  std::u32string result;
  result.reserve(text.size());
  for (size_t i = 0; i < text.size(); ++i) {
    const char32_t c = text[i];
    if (c == kCapitalDottedI) {
      result.push_back(U'i');
      result.push_back(kCombiningDot);
    } else if (c == kCapitalSigma) {
      const bool final_form =
          FindsCased(std::make_reverse_iterator(text.begin() + i),
                     text.rend()) &&
          !FindsCased(text.begin() + i + 1, text.end());
      result.push_back(final_form ? kFinalSigma : kSmallSigma);
    } else {
      result.push_back(Lower(c));
    }
  }
  return result;
}

}  // namespace freegs::semantics
