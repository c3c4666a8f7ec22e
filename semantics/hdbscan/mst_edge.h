// SPDX-License-Identifier: BSD-3-Clause
// An edge of a minimum spanning tree under mutual reachability distance.

#ifndef FREEGS_SEMANTICS_HDBSCAN_MST_EDGE_H_
#define FREEGS_SEMANTICS_HDBSCAN_MST_EDGE_H_

#include <cstdint>

namespace freegs::semantics {

// An edge between rows a < b.
struct MstEdge {
  // Squared mutual reachability distance:
  // max(core(a)^2, core(b)^2, |x_a - x_b|^2).
  double weight2 = 0;
  uint32_t a = 0;
  uint32_t b = 0;

  // A total order: with it the tree is unique even where weights tie, and thus
  // independent of the search order and the number of threads.
  friend bool operator<(const MstEdge& x, const MstEdge& y) {
    if (x.weight2 != y.weight2) return x.weight2 < y.weight2;
    if (x.a != y.a) return x.a < y.a;
    return x.b < y.b;
  }
  friend bool operator==(const MstEdge& x, const MstEdge& y) = default;
};

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_HDBSCAN_MST_EDGE_H_
