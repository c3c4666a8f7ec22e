// SPDX-License-Identifier: BSD-3-Clause

#include "core/number_text.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <iterator>

namespace freegs {
namespace {

constexpr char kNothing[] = "\u2013";  // An en dash.

}  // namespace

std::string FormatFixed(double value, int decimals) {
  if (!std::isfinite(value)) return kNothing;
  char text[400];  // The largest double has 309 digits.
  std::snprintf(text, sizeof(text), "%.*f", decimals, value);
  return text;
}

int DecimalsApart(double value, double limit, int decimals) {
  const int most = decimals + 3;
  while (decimals < most &&
         FormatFixed(value, decimals) == FormatFixed(limit, decimals)) {
    ++decimals;
  }
  return decimals;
}

int DecimalsFor(double length) {
  constexpr int kUsual = 3;
  constexpr int kMost = 12;
  if (!(length > 0) || !std::isfinite(length)) return kUsual;
  return std::clamp(
      2 - static_cast<int>(std::floor(std::log10(length))), 0, kMost);
}

std::string FormatSignificant(double value, int digits) {
  if (!std::isfinite(value)) return kNothing;
  char text[64];
  std::snprintf(text, sizeof(text), "%.*g", digits, value);
  return text;
}

std::string FormatPercent(double share) {
  if (!(std::abs(share) < 1e15)) return kNothing;
  return std::to_string(std::llround(100 * share)) + " %";
}

std::string FormatCount(int64_t count) {
  std::string digits = std::to_string(count);
  const std::ptrdiff_t first = digits[0] == '-' ? 1 : 0;
  for (std::ptrdiff_t at = std::ssize(digits) - 3; at > first; at -= 3) {
    digits.insert(static_cast<size_t>(at), 1, ',');
  }
  return digits;
}

std::string FormatSeconds(double seconds) {
  if (!std::isfinite(seconds) || seconds < 0) return kNothing;
  if (seconds > 1e9) return "over 30 years";
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

}  // namespace freegs
