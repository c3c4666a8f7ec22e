// SPDX-License-Identifier: BSD-3-Clause
// Which of n things are connected, as connections come to be known
// (union-find).

#ifndef FREEGS_CORE_DISJOINT_SETS_H_
#define FREEGS_CORE_DISJOINT_SETS_H_

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

namespace freegs {

// The smallest member stands for its set, whatever the order of calls. Path
// halving, without ranks: logarithmic, amortised.
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

  // Makes one set of two; false when they were one.
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
