// SPDX-License-Identifier: BSD-3-Clause

#include "stages/report/html.h"

#include <cmath>
#include <cstdio>

#include "pipeline/json_text.h"

namespace freegs::stages {
namespace {

constexpr char kNothing[] = "\u2013";  // An en dash.

}  // namespace

std::string EscapeHtml(std::string_view text) {
  std::string escaped;
  for (const char c : pipeline::ValidUtf8(std::string(text))) {
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      case '\'':
        escaped += "&#39;";
        break;
      default:
        if ((static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\t') ||
            c == 0x7f) {
          escaped += "\ufffd";
        } else {
          escaped += c;
        }
    }
  }
  return escaped;
}

std::string EncodeUrlPath(std::string_view path) {
  constexpr std::string_view kPlain =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-._~/";
  std::string encoded;
  for (const char c : path) {
    if (kPlain.find(c) != std::string_view::npos) {
      encoded += c;
    } else {
      char hex[4];
      std::snprintf(hex, sizeof(hex), "%%%02X", static_cast<unsigned char>(c));
      encoded += hex;
    }
  }
  return encoded;
}

std::string FormatFixed(double value, int decimals) {
  if (!std::isfinite(value)) return kNothing;
  char text[400];  // The largest double has 309 digits.
  std::snprintf(text, sizeof(text), "%.*f", decimals, value);
  return text;
}

std::string FormatCount(int64_t count) {
  std::string digits = std::to_string(count);
  const std::ptrdiff_t first = digits[0] == '-' ? 1 : 0;
  for (std::ptrdiff_t at = std::ssize(digits) - 3; at > first; at -= 3) {
    digits.insert(static_cast<size_t>(at), ",");
  }
  return digits;
}

std::string FormatSeconds(double seconds) {
  if (!std::isfinite(seconds) || seconds < 0 || seconds > 1e9) return kNothing;
  if (seconds < 9.95) return FormatFixed(seconds, 1) + " s";
  const int64_t total = std::llround(seconds);
  char text[64];
  if (total < 60) {
    std::snprintf(text, sizeof(text), "%d s", static_cast<int>(total));
  } else if (total < 3600) {
    std::snprintf(text,
                  sizeof(text),
                  "%d min %02d s",
                  static_cast<int>(total / 60),
                  static_cast<int>(total % 60));
  } else {
    std::snprintf(text,
                  sizeof(text),
                  "%lld h %02d min",
                  static_cast<long long>(total / 3600),
                  static_cast<int>(total % 3600 / 60));
  }
  return text;
}

std::string FormatBytes(double bytes) {
  if (!std::isfinite(bytes) || bytes < 0) return kNothing;
  constexpr const char* kUnits[] = {"B", "kB", "MB", "GB", "TB"};
  size_t unit = 0;
  while (bytes >= 999.5 && unit + 1 < std::size(kUnits)) {
    bytes /= 1000;
    ++unit;
  }
  return FormatFixed(bytes, unit > 0 && bytes < 99.95 ? 1 : 0) + " " +
         kUnits[unit];
}

}  // namespace freegs::stages
