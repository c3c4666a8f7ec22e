// SPDX-License-Identifier: BSD-3-Clause
// Two medians. They differ where the number of values is even.

#ifndef FREEGS_CORE_MEDIAN_H_
#define FREEGS_CORE_MEDIAN_H_

#include <algorithm>
#include <cstddef>
#include <vector>

namespace freegs {

// One of the values: the middle one, of two the larger. 0 without values; none
// may be NaN.
template <typename T>
T UpperMedian(std::vector<T> values) {
  if (values.empty()) return T{0};
  const auto middle =
      values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// The middle value, or the mean of the two. 0 without values; none may be NaN.
inline double Median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle =
      values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) return *middle;
  return (*std::max_element(values.begin(), middle) + *middle) / 2;
}

}  // namespace freegs

#endif  // FREEGS_CORE_MEDIAN_H_
