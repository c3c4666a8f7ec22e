// SPDX-License-Identifier: BSD-3-Clause
// Which views are looked at where all of them would only cost time.

#ifndef FREEGS_SEMANTICS_GEOMETRY_VIEW_CHOICE_H_
#define FREEGS_SEMANTICS_GEOMETRY_VIEW_CHOICE_H_

#include <algorithm>
#include <cstddef>
#include <vector>

namespace freegs::semantics {

// The numbers of at most max_count of `count` views, evenly spread. The same
// number of them again gives all of those.
inline std::vector<size_t> ChooseViews(size_t count, size_t max_count) {
  const size_t chosen = std::min(count, max_count);
  std::vector<size_t> views;
  for (size_t i = 0; i < chosen; ++i) views.push_back(i * count / chosen);
  return views;
}

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_GEOMETRY_VIEW_CHOICE_H_
