// SPDX-License-Identifier: BSD-3-Clause

#include "sfm/matching/photo_sequence.h"

#include <algorithm>
#include <map>
#include <utility>

#include "core/text.h"

namespace freegs::sfm {
namespace {

// A number of any length, in an order that is that of its value.
using Number = std::pair<size_t, std::string>;

struct NumberedName {
  std::string pattern;  // The name with each number replaced by one mark.
  std::vector<Number> numbers;
};

NumberedName Parse(const std::string& name) {
  NumberedName result;
  for (size_t at = 0; at < name.size();) {
    if (!IsDigit(name[at])) {
      result.pattern += name[at++];
      continue;
    }
    size_t end = at;
    while (end < name.size() && IsDigit(name[end])) ++end;
    while (at + 1 < end && name[at] == '0') ++at;
    result.numbers.emplace_back(end - at, name.substr(at, end - at));
    result.pattern += '\0';
    at = end;
  }
  return result;
}

}  // namespace

std::vector<std::vector<int>> FindNumberedPhotos(
    const std::vector<std::string>& names, int min_photos) {
  std::map<std::string, std::vector<std::pair<std::vector<Number>, int>>>
      by_pattern;
  for (size_t i = 0; i < names.size(); ++i) {
    NumberedName name = Parse(names[i]);
    if (name.numbers.empty()) continue;
    by_pattern[name.pattern].emplace_back(std::move(name.numbers),
                                          static_cast<int>(i));
  }
  std::vector<std::vector<int>> groups;
  for (auto& [pattern, photos] : by_pattern) {
    if (static_cast<int>(photos.size()) < min_photos) continue;
    std::sort(photos.begin(), photos.end());
    std::vector<int>& group = groups.emplace_back();
    for (const auto& photo : photos) group.push_back(photo.second);
  }
  std::sort(groups.begin(), groups.end(), [](const auto& a, const auto& b) {
    if (a.size() != b.size()) return a.size() > b.size();
    return a.front() < b.front();
  });
  return groups;
}

}  // namespace freegs::sfm
