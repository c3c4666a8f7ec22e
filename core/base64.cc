// SPDX-License-Identifier: BSD-3-Clause

#include "core/base64.h"

#include <cstddef>
#include <cstdint>

namespace freegs {
namespace {

constexpr std::string_view kDigits =
    "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

// 64 for what is no digit.
uint32_t DigitValue(char c) {
  if (c >= 'A' && c <= 'Z') return c - 'A';
  if (c >= 'a' && c <= 'z') return c - 'a' + 26;
  if (c >= '0' && c <= '9') return c - '0' + 52;
  if (c == '+') return 62;
  return c == '/' ? 63 : 64;
}

}  // namespace

std::string EncodeBase64(std::string_view bytes) {
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (size_t i = 0; i < bytes.size(); i += 3) {
    const size_t count = bytes.size() - i < 3 ? bytes.size() - i : 3;
    uint32_t group = 0;
    for (size_t k = 0; k < 3; ++k) {
      group = group << 8 |
              (k < count ? static_cast<uint8_t>(bytes[i + k]) : uint8_t{0});
    }
    for (size_t k = 0; k < 4; ++k) {
      text.push_back(k <= count ? kDigits[group >> (18 - 6 * k) & 63] : '=');
    }
  }
  return text;
}

StatusOr<std::string> DecodeBase64(std::string_view text) {
  if (text.size() % 4 != 0) {
    return BadInputError("base64: the length is no multiple of four");
  }
  size_t padding = 0;
  while (padding < 2 && padding < text.size() &&
         text[text.size() - 1 - padding] == '=') {
    ++padding;
  }
  std::string bytes;
  bytes.reserve(text.size() / 4 * 3);
  for (size_t i = 0; i < text.size(); i += 4) {
    const size_t digits = i + 4 == text.size() ? 4 - padding : 4;
    uint32_t group = 0;
    for (size_t k = 0; k < 4; ++k) {
      const uint32_t value = k < digits ? DigitValue(text[i + k]) : 0;
      if (value == 64) {
        return BadInputError("base64: there is another character");
      }
      group = group << 6 | value;
    }
    const size_t count = digits - 1;
    if ((group & ((1u << (24 - 8 * count)) - 1)) != 0) {
      return BadInputError("base64: bits at the end stand for no byte");
    }
    for (size_t k = 0; k < count; ++k) {
      bytes.push_back(static_cast<char>(group >> (16 - 8 * k) & 0xff));
    }
  }
  return bytes;
}

}  // namespace freegs
