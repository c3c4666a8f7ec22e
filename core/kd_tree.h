// SPDX-License-Identifier: BSD-3-Clause
// A k-d tree over points of low dimension. It serves exact clustering: boxes
// are tight, every query has one right answer, and equal points are no special
// case.

#ifndef FREEGS_CORE_KD_TREE_H_
#define FREEGS_CORE_KD_TREE_H_

#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "core/kd_tree_simd.h"
#include "core/status.h"

namespace freegs {

// Neighbours are ordered by distance and then by index, so that the k nearest
// are one well-defined list even among equal distances.
struct Neighbor {
  double distance2 = 0;  // Squared Euclidean distance.
  uint32_t index = 0;    // Row of the point.

  friend bool operator<(const Neighbor& a, const Neighbor& b) {
    return a.distance2 != b.distance2 ? a.distance2 < b.distance2
                                      : a.index < b.index;
  }
};

// Iterates over the children of a node that are within a limit, nearest first.
// `within` has a bit for each of them.
class KdChildOrder {
 public:
  KdChildOrder(const float bounds[kKdBlockSize], uint32_t within) {
    for (; within != 0; within &= within - 1) {
      const int j = std::countr_zero(within);
      int at = count_++;
      for (; at > 0 && bounds[order_[at - 1]] > bounds[j]; --at) {
        order_[at] = order_[at - 1];
      }
      order_[at] = static_cast<int8_t>(j);
    }
  }
  // The next child, or -1 at the end.
  int Next() { return next_ < count_ ? order_[next_++] : -1; }

 private:
  int8_t order_[kKdBlockSize];
  int count_ = 0;
  int next_ = 0;
};

// A search tree over the rows of a matrix of points:
//
//   FREEGS_ASSIGN_OR_RETURN(const KdTree tree, KdTree::Build(points, 3));
//   std::vector<Neighbor> nearest;
//   tree.Nearest(query, /*k=*/8, KdTree::kNoRow, &nearest);
//
// Every node has kFanout children and every leaf kFanout points; only the last
// node of a level may have fewer. Leaves are level 0. The nodes of a level are
// numbered from 0, and node i holds the tree positions
// [i * PointsPerNode(level), (i + 1) * PointsPerNode(level)). Building splits
// points across the widest side of their box, near the median.
//
// Squared distances are sums in double over the float coordinates, in the order
// of the dimensions. So they are symmetric in the two points and the same
// wherever they are computed. Distances to boxes are computed in the same way,
// and because rounding is monotone they never exceed the distance to a point
// inside the box. Searches compare bounds in float first. Squares of distances
// below 1e-18 are too small for that: such searches are right but slow.
class KdTree {
 public:
  static constexpr int kFanout = kKdBlockSize;
  // Larger coordinates are refused: their squares would overflow a float.
  static constexpr float kMaxCoordinate = 1e15f;

  // `points` is an N x dim matrix, row by row, with N < 2^31. Returns
  // kInvalidArgument when its size is not a multiple of dim, or when a
  // coordinate is not finite or its absolute value exceeds kMaxCoordinate.
  static StatusOr<KdTree> Build(std::span<const float> points, int dim);

  size_t size() const { return order_.size(); }
  int dim() const { return dim_; }

  // The last level has one node, the root. A tree without points has no level.
  int num_levels() const { return static_cast<int>(levels_.size()); }
  uint32_t num_nodes(int level) const { return levels_[level].num_nodes; }
  static size_t PointsPerNode(int level) {
    return size_t{1} << (4 * (level + 1));
  }
  // Smallest row among the points of a node.
  uint32_t MinRow(int level, uint32_t node) const {
    return levels_[level].min_rows[node];
  }

  // Row of the point at a tree position, and its coordinates.
  uint32_t Row(uint32_t position) const { return order_[position]; }
  const float* Point(uint32_t position) const {
    return rows_.data() + static_cast<size_t>(position) * dim_;
  }

  double Distance2(const float* a, const float* b) const {
    double sum = 0;
    for (int k = 0; k < dim_; ++k) {
      const double difference = static_cast<double>(a[k]) - b[k];
      sum += difference * difference;
    }
    return sum;
  }

  // Squared distance to the node's tight bounding box, 0 inside.
  double BoxDistance2(int level, uint32_t node, const float* query) const;

  // Computes fast lower bounds (see kd_tree_simd.h) of the squared distances
  // from the query to the children of a node, or to the points of a leaf.
  // Returns a bit for each that is at most `limit2`.
  uint32_t ChildBounds(int level,
                       uint32_t node,
                       const float* query,
                       double limit2,
                       float bounds[kFanout]) const {
    return level == 0
               ? KdPointBounds(
                     Block(0, node), dim_, query, Limit(limit2), bounds)
               : KdBoxBounds(
                     Block(level, node), dim_, query, Limit(limit2), bounds);
  }
  KdBlockBounds ChildBounds(int level,
                            uint32_t node,
                            const float* query,
                            const KdBlockFilter& filter,
                            double limit2,
                            float bounds[kFanout]) const {
    return level == 0
               ? KdPointBounds(
                     Block(0, node), dim_, query, filter, Limit(limit2), bounds)
               : KdBoxBounds(Block(level, node),
                             dim_,
                             query,
                             filter,
                             Limit(limit2),
                             bounds);
  }
  // Whether the exact value of a bound, which is within the limit, may be equal
  // to the limit. If false, the exact value is smaller for sure.
  bool MayTie(float bound, double limit2) const {
    return bound >= limit2 * tie_factor_;
  }

  // The k nearest points to the query, nearest first; fewer when the tree is
  // smaller. The point at row `skip` is left out (kNoRow for none).
  static constexpr uint32_t kNoRow = 0xffffffffu;
  void Nearest(const float* query,
               int k,
               uint32_t skip,
               std::vector<Neighbor>* result) const;

 private:
  struct Level {
    uint32_t num_nodes = 0;
    std::vector<uint32_t> min_rows;
    std::vector<float> blocks;  // Per node; layout in kd_tree_simd.h.
  };
  struct KnnQuery;

  size_t BlockSize(int level) const {
    return static_cast<size_t>(dim_) * kFanout * (level == 0 ? 1 : 2);
  }
  const float* Block(int level, uint32_t node) const {
    return levels_[level].blocks.data() + node * BlockSize(level);
  }
  // Entries that do not exist are infinitely far and never within.
  static float Limit(double limit2) {
    constexpr float kMax = std::numeric_limits<float>::max();
    return limit2 < kMax ? static_cast<float>(limit2) : kMax;
  }
  void Split(uint32_t begin, uint32_t end, std::span<const float> points);
  void FillLeaves();
  void FillLevel(int level);
  void Search(int level, uint32_t node, KnnQuery& query) const;

  int dim_ = 0;
  double tie_factor_ = 0;
  std::vector<uint32_t> order_;  // Row at each tree position.
  std::vector<float> rows_;      // N x dim, tree order.
  std::vector<Level> levels_;    // From the leaves up.
};

}  // namespace freegs

#endif  // FREEGS_CORE_KD_TREE_H_
