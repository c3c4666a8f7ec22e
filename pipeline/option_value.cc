// SPDX-License-Identifier: BSD-3-Clause

#include "pipeline/option_value.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numeric>
#include <type_traits>

namespace freegs::pipeline {
namespace {

template <typename T>
std::string NumberText(T value) {
  if constexpr (std::is_floating_point_v<T>) {
    // 100000 reads better than the shorter 1e+05.
    if (value == std::trunc(value) && std::abs(value) < 1e15) {
      return std::to_string(static_cast<int64_t>(value));
    }
  }
  std::array<char, 64> buffer;
  const auto result =
      std::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
  return std::string(buffer.data(), result.ptr);
}

template <typename T>
Status ParseNumber(const std::string& text, const OptionSpec& spec, T* value) {
  constexpr bool kInteger = std::is_integral_v<T>;
  const char* begin = text.data();
  const char* end = begin + text.size();
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') ++begin;
  const auto result = std::from_chars(begin, end, *value);
  const std::string quoted = "'" + text + "'";
  if (result.ec == std::errc::result_out_of_range) {
    return InvalidArgumentError(quoted + " does not fit");
  }
  if (result.ec != std::errc() || result.ptr != end) {
    return InvalidArgumentError(quoted + " is not a " +
                                (kInteger ? "whole number" : "number"));
  }
  const double number = static_cast<double>(*value);
  if (!std::isfinite(number)) {
    return InvalidArgumentError(quoted + " is not a finite number");
  }
  if ((spec.min && number < *spec.min) || (spec.max && number > *spec.max)) {
    return InvalidArgumentError(quoted + " is out of range");
  }
  return Status();
}

Status Parse(const std::string& text, const OptionSpec&, bool* value) {
  for (const char* word : {"true", "yes", "on", "1"}) {
    if (text == word) {
      *value = true;
      return Status();
    }
  }
  for (const char* word : {"false", "no", "off", "0"}) {
    if (text == word) {
      *value = false;
      return Status();
    }
  }
  return InvalidArgumentError("'" + text + "' is not true or false");
}

Status Parse(const std::string& text, const OptionSpec& spec, int* value) {
  return ParseNumber(text, spec, value);
}

Status Parse(const std::string& text, const OptionSpec& spec, int64_t* value) {
  return ParseNumber(text, spec, value);
}

Status Parse(const std::string& text, const OptionSpec& spec, double* value) {
  return ParseNumber(text, spec, value);
}

Status Parse(const std::string& text,
             const OptionSpec& spec,
             std::string* value) {
  if (!spec.choices.empty() &&
      std::find(spec.choices.begin(), spec.choices.end(), text) ==
          spec.choices.end()) {
    return InvalidArgumentError("'" + text + "' is not a choice");
  }
  *value = text;
  return Status();
}

size_t EditDistance(const std::string& a, const std::string& b) {
  std::vector<size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), size_t{0});
  for (size_t i = 0; i < a.size(); ++i) {
    size_t diagonal = row[0];
    row[0] = i + 1;
    for (size_t j = 0; j < b.size(); ++j) {
      const size_t substitution = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({row[j] + 1, row[j + 1] + 1, substitution});
    }
  }
  return row.back();
}

}  // namespace

std::string OptionText(const OptionTarget& target) {
  return std::visit(
      [](const auto* value) -> std::string {
        using T = std::remove_cvref_t<decltype(*value)>;
        if constexpr (std::is_same_v<T, bool>) {
          return *value ? "true" : "false";
        } else if constexpr (std::is_same_v<T, std::string>) {
          return *value;
        } else {
          return NumberText(*value);
        }
      },
      target);
}

Status ParseOptionText(const std::string& text,
                       const OptionSpec& spec,
                       const OptionTarget& target,
                       bool store) {
  return std::visit(
      [&](auto* value) -> Status {
        std::remove_cvref_t<decltype(*value)> parsed{};
        FREEGS_RETURN_IF_ERROR(Parse(text, spec, &parsed));
        if (spec.accepts != nullptr && !spec.accepts(text)) {
          return InvalidArgumentError("'" + text + "' is not allowed");
        }
        if (store) *value = std::move(parsed);
        return Status();
      },
      target);
}

std::string AllowedText(const OptionSpec& spec, const OptionTarget& target) {
  if (!spec.allowed.empty()) return spec.allowed;
  if (std::holds_alternative<bool*>(target)) return "true or false";
  if (std::holds_alternative<std::string*>(target)) {
    if (spec.choices.empty()) return spec.is_path ? "a path" : "text";
    std::string text;
    for (const std::string& choice : spec.choices) {
      text += (text.empty() ? "" : ", ") + choice;
    }
    return text;
  }
  if (spec.min && spec.max) {
    return NumberText(*spec.min) + " .. " + NumberText(*spec.max);
  }
  if (spec.min) return "at least " + NumberText(*spec.min);
  if (spec.max) return "at most " + NumberText(*spec.max);
  return std::holds_alternative<double*>(target) ? "a number"
                                                 : "a whole number";
}

std::string NearestName(const std::string& name,
                        const std::vector<std::string>& candidates) {
  // Beyond a third of its letters wrong, a name is more likely another thing.
  size_t best = name.size() / 3 + 1;
  if (name.size() > 200) return "";
  std::string nearest;
  for (const std::string& candidate : candidates) {
    const size_t distance = EditDistance(name, candidate);
    if (distance < best || (distance == best && nearest.empty())) {
      best = distance;
      nearest = candidate;
    }
  }
  return nearest;
}

}  // namespace freegs::pipeline
