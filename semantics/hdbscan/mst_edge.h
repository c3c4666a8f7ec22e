// SPDX-License-Identifier: BSD-3-Clause
// An edge of the minimum spanning tree of mutual reachability distances.

#ifndef FREEGS_SEMANTICS_HDBSCAN_MST_EDGE_H_
#define FREEGS_SEMANTICS_HDBSCAN_MST_EDGE_H_

#include <cstdint>

namespace freegs::semantics {

// An edge between the points of rows a and b, where a < b.
struct MstEdge {
  // The square of the mutual reachability distance: max(core(a)^2, core(b)^2,
  // |x_a - x_b|^2).
  double weight2 = 0;
  uint32_t a = 0;
  uint32_t b = 0;

  // Edges are ordered by weight, then by rows. Under this total order the tree
  // is unique even if weights are equal, so that it does not depend on the
  // order of the search or the number of threads.
  friend bool operator<(const MstEdge& x, const MstEdge& y) {
    if (x.weight2 != y.weight2) return x.weight2 < y.weight2;
    if (x.a != y.a) return x.a < y.a;
    return x.b < y.b;
  }
  friend bool operator==(const MstEdge& x, const MstEdge& y) = default;
};

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_HDBSCAN_MST_EDGE_H_
