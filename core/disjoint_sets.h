// SPDX-License-Identifier: BSD-3-Clause
// Groups n things into connected sets while connections are added one by one
// (union-find).

#ifndef FREEGS_CORE_DISJOINT_SETS_H_
#define FREEGS_CORE_DISJOINT_SETS_H_

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

namespace freegs {

// Sets of the numbers 0 .. count - 1. At first each number is a set of its own:
//
//   DisjointSets sets(photos.size());
//   for (const auto& [a, b] : matched_pairs) sets.Join(a, b);
//   const bool connected = sets.Find(0) == sets.Find(1);
//
// The smallest member stands for its set, whatever the order of calls. A call
// takes amortised logarithmic time (path halving, no ranks).
class DisjointSets {
 public:
  explicit DisjointSets(size_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), 0u);
  }

  size_t size() const { return parent_.size(); }

  // The smallest member of i's set.
  uint32_t Find(uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }

  // Unites the sets of i and j. Returns false when they already were one set.
  bool Join(uint32_t i, uint32_t j) {
    const uint32_t a = Find(i);
    const uint32_t b = Find(j);
    parent_[std::max(a, b)] = std::min(a, b);
    return a != b;
  }

 private:
  std::vector<uint32_t> parent_;
};

}  // namespace freegs

#endif  // FREEGS_CORE_DISJOINT_SETS_H_
