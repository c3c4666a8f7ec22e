// SPDX-License-Identifier: BSD-3-Clause
// Medians and quantiles of values in any order. They differ in what they
// return when no single value lies at the rank asked for: the lower or the
// upper neighbour, the nearer one, or the mean of both. None of the values may
// be NaN. Without values each returns 0, except ValueOfRank, which needs one.

#ifndef FREEGS_CORE_QUANTILE_H_
#define FREEGS_CORE_QUANTILE_H_

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

namespace freegs {

// The value that would have this index (0 .. size - 1) if the values were
// sorted. There must be values.
template <typename T>
T ValueOfRank(std::vector<T> values, size_t rank) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(rank);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

// One of the values: that of rank share * (size - 1), rounded down. share must
// be in [0, 1].
template <typename T>
T LowerQuantile(std::vector<T> values, double share) {
  if (values.empty()) return T{0};
  const double rank = share * static_cast<double>(values.size() - 1);
  return ValueOfRank(std::move(values), static_cast<size_t>(rank));
}

// One of the values: that of rank share * (size - 1), rounded to the nearest
// whole number, halves up. share must be in [0, 1].
template <typename T>
T NearestQuantile(std::vector<T> values, double share) {
  if (values.empty()) return T{0};
  const double rank = share * static_cast<double>(values.size() - 1);
  return ValueOfRank(std::move(values),
                     static_cast<size_t>(std::floor(rank + 0.5)));
}

// One of the values: the middle one, or the larger of the middle two.
template <typename T>
T UpperMedian(std::vector<T> values) {
  if (values.empty()) return T{0};
  const size_t rank = values.size() / 2;
  return ValueOfRank(std::move(values), rank);
}

// The middle value, or the mean of the middle two.
inline double Median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle =
      values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) return *middle;
  return (*std::max_element(values.begin(), middle) + *middle) / 2;
}

}  // namespace freegs

#endif  // FREEGS_CORE_QUANTILE_H_
