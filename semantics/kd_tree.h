// SPDX-License-Identifier: BSD-3-Clause
// A k-d tree over points of low dimension, with what exact clustering needs:
// tight boxes, a unique answer to every query, and no trouble with duplicates.

#ifndef FREEGS_SEMANTICS_KD_TREE_H_
#define FREEGS_SEMANTICS_KD_TREE_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/status.h"

namespace freegs::semantics {

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

// Split at the median of the widest side; leaves hold up to kLeafSize points.
// Squared distances are summed in double from the float coordinates, in order
// of dimension: symmetric in the two points, and the same wherever they are
// computed. Box distances are computed alike, and because rounding is monotone
// they never exceed the distance of a point inside.
class KdTree {
 public:
  static constexpr int kLeafSize = 16;
  // Larger coordinates are refused: their squares would overflow a float.
  static constexpr float kMaxCoordinate = 1e15f;

  struct Node {
    uint32_t begin = 0;  // Points [begin, end) in tree order.
    uint32_t end = 0;
    // Right child; 0 for a leaf. The left child is the next node.
    uint32_t right = 0;
    uint32_t min_index = 0;  // Smallest row among the points.

    bool is_leaf() const { return right == 0; }
  };

  // points: N x dim, row-major, N < 2^31. kInvalidArgument when the size is not
  // a multiple of dim, or a coordinate is not finite or larger than
  // kMaxCoordinate.
  static StatusOr<KdTree> Build(std::span<const float> points, int dim);

  size_t size() const { return order_.size(); }
  int dim() const { return dim_; }

  // Parents come before their children; the root is node 0 (if size() > 0).
  const std::vector<Node>& nodes() const { return nodes_; }

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
  double BoxDistance2(uint32_t node, const float* query) const {
    const float* low = boxes_.data() + static_cast<size_t>(node) * 2 * dim_;
    const float* high = low + dim_;
    double sum = 0;
    for (int k = 0; k < dim_; ++k) {
      const double below = static_cast<double>(low[k]) - query[k];
      const double above = static_cast<double>(query[k]) - high[k];
      const double outside = below > above ? below : above;
      sum += outside > 0 ? outside * outside : 0;
    }
    return sum;
  }

  // Fast lower bounds (in float, rounded down by more than their error) of the
  // squared distances from the query to the points of a leaf.
  void LeafLowerBounds(const Node& leaf,
                       const float* query,
                       float bounds[kLeafSize]) const;

  // The k nearest points to the query, nearest first; fewer when the tree is
  // smaller. The point at row `skip` is left out (kNoRow for none).
  static constexpr uint32_t kNoRow = 0xffffffffu;
  void Nearest(const float* query,
               int k,
               uint32_t skip,
               std::vector<Neighbor>* result) const;

 private:
  struct KnnQuery;
  void Build(uint32_t begin, uint32_t end, std::span<const float> points);
  void Search(uint32_t node, KnnQuery& query) const;

  int dim_ = 0;
  std::vector<uint32_t> order_;  // Row at each tree position.
  std::vector<float> rows_;      // N x dim, tree order.
  std::vector<float> blocks_;    // Leaves: dim x kLeafSize each.
  std::vector<uint32_t> block_;  // Block of each node; unused for inner nodes.
  std::vector<float> boxes_;     // Per node: dim minima, dim maxima.
  std::vector<Node> nodes_;
};

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_KD_TREE_H_
