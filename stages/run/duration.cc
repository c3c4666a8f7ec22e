// SPDX-License-Identifier: BSD-3-Clause

#include "stages/run/duration.h"

#include <charconv>
#include <string>
#include <system_error>

namespace freegs::stages {
namespace {

constexpr double kYear = 365.0 * 86400;

Status NotADuration(std::string_view text) {
  return InvalidArgumentError("'" + std::string(text) +
                              "' is not a duration; write 90s, 5m or 1h30m");
}

double SecondsOf(char unit) {
  return unit == 'h' ? 3600 : unit == 'm' ? 60 : 1;
}

}  // namespace

StatusOr<double> ParseDuration(std::string_view text) {
  const char* next = text.data();
  const char* const end = next + text.size();
  std::string_view units = "hms";
  double seconds = 0;
  do {
    // from_chars also takes signs, "inf" and "nan".
    if (next == end || *next < '0' || *next > '9') return NotADuration(text);
    double number = 0;
    const auto [after, error] =
        std::from_chars(next, end, number, std::chars_format::fixed);
    if (error != std::errc()) return NotADuration(text);
    const bool only_number = after == end && next == text.data();
    const char unit = only_number ? 's' : after == end ? '?' : *after;
    const size_t place = units.find(unit);
    if (place == std::string_view::npos) return NotADuration(text);
    units.remove_prefix(place + 1);
    seconds += number * SecondsOf(unit);
    next = only_number ? end : after + 1;
  } while (next != end);
  if (!(seconds > 0 && seconds <= kYear)) return NotADuration(text);
  return seconds;
}

}  // namespace freegs::stages
