// SPDX-License-Identifier: BSD-3-Clause

#include "stages/view/request_target.h"

#include <algorithm>
#include <cstdint>

#include "core/text.h"

namespace freegs::stages {
namespace {

// Takes the text up to the separator off the front of `rest`, and the separator
// too.
std::string_view TakePart(char separator, std::string_view* rest) {
  const size_t end = std::min(rest->find(separator), rest->size());
  const std::string_view part = rest->substr(0, end);
  rest->remove_prefix(std::min(end + 1, rest->size()));
  return part;
}

bool IsPlainPath(std::string_view path) {
  if (!path.starts_with('/')) return false;
  for (const char c : path) {
    if (c == '\\' || static_cast<uint8_t>(c) < 0x20 || c == 0x7f) return false;
  }
  std::string_view rest = path.substr(1);
  while (!rest.empty()) {
    const std::string_view part = TakePart('/', &rest);
    if (part.empty() || part == "." || part == "..") return false;
  }
  return true;
}

}  // namespace

std::optional<RequestTarget> ParseRequestTarget(std::string_view target) {
  RequestTarget result;
  std::string_view query = target;
  const std::optional<std::string> path = PercentDecode(TakePart('?', &query));
  if (!path || !IsPlainPath(*path)) return std::nullopt;
  result.path = *path;
  while (!query.empty()) {
    std::string_view value = TakePart('&', &query);
    const std::optional<std::string> name =
        PercentDecode(TakePart('=', &value));
    const std::optional<std::string> text = PercentDecode(value);
    if (!name || !text) return std::nullopt;
    result.parameters.emplace(*name, *text);
  }
  return result;
}

}  // namespace freegs::stages
