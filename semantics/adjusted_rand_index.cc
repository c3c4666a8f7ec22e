// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/adjusted_rand_index.h"

#include <algorithm>
#include <map>
#include <utility>

namespace freegs::semantics {
namespace {

double Pairs(double count) { return count * (count - 1) / 2; }

template <typename Counts>
double SumOfPairs(const Counts& counts) {
  double sum = 0;
  for (const auto& [key, count] : counts) {
    sum += Pairs(static_cast<double>(count));
  }
  return sum;
}

}  // namespace

double AdjustedRandIndex(std::span<const int32_t> a,
                         std::span<const int32_t> b) {
  const size_t count = std::min(a.size(), b.size());
  std::map<int32_t, int64_t> of_a;
  std::map<int32_t, int64_t> of_b;
  std::map<std::pair<int32_t, int32_t>, int64_t> of_both;
  for (size_t i = 0; i < count; ++i) {
    const int32_t x = std::max(a[i], -1);
    const int32_t y = std::max(b[i], -1);
    ++of_a[x];
    ++of_b[y];
    ++of_both[{x, y}];
  }
  const double pairs_a = SumOfPairs(of_a);
  const double pairs_b = SumOfPairs(of_b);
  const double all = Pairs(static_cast<double>(count));
  const double expected = all > 0 ? pairs_a * pairs_b / all : 0;
  const double most = (pairs_a + pairs_b) / 2;
  if (most == expected) return 1;
  return (SumOfPairs(of_both) - expected) / (most - expected);
}

}  // namespace freegs::semantics
