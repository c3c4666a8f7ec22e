// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/metrics/adjusted_rand_index.h"

#include <algorithm>
#include <string>
#include <vector>

namespace freegs::semantics {
namespace {

// The number of pairs of equal keys. It is exact up to 2^53 pairs, and precise
// enough beyond.
double EqualPairs(std::vector<uint64_t>& keys) {
  std::sort(keys.begin(), keys.end());
  double pairs = 0;
  for (size_t begin = 0; begin < keys.size();) {
    size_t end = begin + 1;
    while (end < keys.size() && keys[end] == keys[begin]) ++end;
    const auto n = static_cast<double>(end - begin);
    pairs += n * (n - 1) / 2;
    begin = end;
  }
  return pairs;
}

}  // namespace

StatusOr<double> AdjustedRandIndex(std::span<const int32_t> a,
                                   std::span<const int32_t> b) {
  if (a.size() != b.size()) {
    return InvalidArgumentError("partitions of " + std::to_string(a.size()) +
                                " and of " + std::to_string(b.size()) +
                                " things cannot be compared");
  }
  if (a.size() < 2) return 1.0;
  std::vector<uint64_t> keys(a.size());
  const auto pairs_of = [&](auto key) {
    for (size_t i = 0; i < keys.size(); ++i) keys[i] = key(i);
    return EqualPairs(keys);
  };
  const double in_a =
      pairs_of([&](size_t i) { return static_cast<uint32_t>(a[i]); });
  const double in_b =
      pairs_of([&](size_t i) { return static_cast<uint32_t>(b[i]); });
  const double in_both = pairs_of([&](size_t i) {
    return static_cast<uint64_t>(static_cast<uint32_t>(a[i])) << 32 |
           static_cast<uint32_t>(b[i]);
  });
  const auto n = static_cast<double>(a.size());
  const double expected = in_a * in_b / (n * (n - 1) / 2);
  const double largest = (in_a + in_b) / 2;
  if (largest == expected) return 1.0;
  return (in_both - expected) / (largest - expected);
}

}  // namespace freegs::semantics
