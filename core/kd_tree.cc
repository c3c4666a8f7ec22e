// SPDX-License-Identifier: BSD-3-Clause

#include "core/kd_tree.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

namespace freegs {

StatusOr<KdTree> KdTree::Build(std::span<const float> points, int dim) {
  if (dim <= 0 || points.size() % dim != 0) {
    return InvalidArgumentError(
        "points must be a multiple of the dimension in number");
  }
  const size_t count = points.size() / dim;
  if (count >= (size_t{1} << 31)) {
    return InvalidArgumentError(
        "too many points for a k-d tree (2^31 or more)");
  }
  for (size_t i = 0; i < points.size(); ++i) {
    if (!(std::abs(points[i]) <= kMaxCoordinate)) {
      return InvalidArgumentError("coordinate " + std::to_string(i % dim) +
                                  " of point " + std::to_string(i / dim) +
                                  " is not finite or too large");
    }
  }
  KdTree tree;
  tree.dim_ = dim;
  tree.tie_factor_ = KdTieFactor(dim);
  tree.order_.resize(count);
  std::iota(tree.order_.begin(), tree.order_.end(), 0u);
  if (count == 0) return tree;
  tree.Split(0, static_cast<uint32_t>(count), points);

  tree.rows_.resize(points.size());
  for (size_t position = 0; position < count; ++position) {
    std::copy_n(
        points.data() + static_cast<size_t>(tree.order_[position]) * dim,
        dim,
        tree.rows_.data() + position * dim);
  }
  tree.FillLeaves();
  while (tree.levels_.back().num_nodes > 1) tree.FillLevel(tree.num_levels());
  return tree;
}

// Orders the points so that the nodes of all levels are compact.
void KdTree::Split(uint32_t begin,
                   uint32_t end,
                   std::span<const float> points) {
  const uint32_t count = end - begin;
  if (count <= kFanout) return;
  const auto point = [&](uint32_t row) {
    return points.data() + static_cast<size_t>(row) * dim_;
  };
  std::vector<float> low(point(order_[begin]), point(order_[begin]) + dim_);
  std::vector<float> high(low);
  for (uint32_t position = begin + 1; position < end; ++position) {
    const float* p = point(order_[position]);
    for (int k = 0; k < dim_; ++k) {
      low[k] = std::min(low[k], p[k]);
      high[k] = std::max(high[k], p[k]);
    }
  }
  int widest = 0;
  for (int k = 1; k < dim_; ++k) {
    if (high[k] - low[k] > high[widest] - low[widest]) widest = k;
  }
  // The left part is a whole number of the largest nodes that divide this one.
  int level = 0;
  while (PointsPerNode(level + 1) < count) ++level;
  const size_t node = PointsPerNode(level);
  const size_t num_nodes = (count + node - 1) / node;
  const auto middle = static_cast<uint32_t>(begin + num_nodes / 2 * node);
  // Equal coordinates are split by row: the depth stays logarithmic whatever
  // the points, and among duplicates the left part holds the smaller rows.
  std::nth_element(order_.begin() + begin,
                   order_.begin() + middle,
                   order_.begin() + end,
                   [&](uint32_t a, uint32_t b) {
                     const float xa = point(a)[widest];
                     const float xb = point(b)[widest];
                     return xa != xb ? xa < xb : a < b;
                   });
  Split(begin, middle, points);
  Split(middle, end, points);
}

void KdTree::FillLeaves() {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  Level leaves;
  leaves.num_nodes = static_cast<uint32_t>((size() + kFanout - 1) / kFanout);
  leaves.min_rows.assign(leaves.num_nodes, kNoRow);
  leaves.blocks.assign(leaves.num_nodes * BlockSize(0), kInfinity);
  for (size_t position = 0; position < size(); ++position) {
    const size_t leaf = position / kFanout;
    uint32_t& min_row = leaves.min_rows[leaf];
    min_row = std::min(min_row, order_[position]);
    float* block =
        leaves.blocks.data() + leaf * BlockSize(0) + position % kFanout;
    for (int k = 0; k < dim_; ++k) {
      block[k * kFanout] = Point(static_cast<uint32_t>(position))[k];
    }
  }
  levels_.push_back(std::move(leaves));
}

void KdTree::FillLevel(int level) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const Level& below = levels_.back();
  Level filled;
  filled.num_nodes = (below.num_nodes + kFanout - 1) / kFanout;
  filled.min_rows.assign(filled.num_nodes, kNoRow);
  filled.blocks.resize(filled.num_nodes * BlockSize(level));
  // Per node and dimension: the lower ends of its children, the upper ends.
  float* ends = filled.blocks.data();
  for (uint32_t node = 0; node < filled.num_nodes; ++node) {
    for (int k = 0; k < dim_; ++k, ends += 2 * kFanout) {
      std::fill_n(ends, kFanout, kInfinity);
      std::fill_n(ends + kFanout, kFanout, -kInfinity);
    }
  }
  const size_t child_points = PointsPerNode(level - 1);
  for (uint32_t child = 0; child < below.num_nodes; ++child) {
    uint32_t& min_row = filled.min_rows[child / kFanout];
    min_row = std::min(min_row, below.min_rows[child]);
    float* low = filled.blocks.data() + child / kFanout * BlockSize(level) +
                 child % kFanout;
    const size_t end = std::min(size(), (child + 1) * child_points);
    for (size_t position = child * child_points; position < end; ++position) {
      const float* point = Point(static_cast<uint32_t>(position));
      for (int k = 0; k < dim_; ++k) {
        float& least = low[k * 2 * kFanout];
        float& most = low[k * 2 * kFanout + kFanout];
        least = std::min(least, point[k]);
        most = std::max(most, point[k]);
      }
    }
  }
  levels_.push_back(std::move(filled));
}

double KdTree::BoxDistance2(int level,
                            uint32_t node,
                            const float* query) const {
  if (level + 1 == num_levels()) return 0;  // The root's box is not kept.
  const float* low = Block(level + 1, node / kFanout) + node % kFanout;
  double sum = 0;
  for (int k = 0; k < dim_; ++k) {
    const double below = static_cast<double>(low[k * 2 * kFanout]) - query[k];
    const double above =
        static_cast<double>(query[k]) - low[k * 2 * kFanout + kFanout];
    const double outside = below > above ? below : above;
    sum += outside > 0 ? outside * outside : 0;
  }
  return sum;
}

// The best k found so far, as a heap with the worst on top.
struct KdTree::KnnQuery {
  const float* point;
  size_t k;
  uint32_t skip;
  std::vector<Neighbor>& heap;
  double limit2 = std::numeric_limits<double>::infinity();

  bool CanImprove(double distance2, uint32_t row) const {
    return heap.size() < k || Neighbor{distance2, row} < heap.front();
  }
  void Add(double distance2, uint32_t row) {
    if (heap.size() == k) {
      std::pop_heap(heap.begin(), heap.end());
      heap.back() = {distance2, row};
    } else {
      heap.push_back({distance2, row});
    }
    std::push_heap(heap.begin(), heap.end());
    if (heap.size() == k) limit2 = heap.front().distance2;
  }
};

void KdTree::Search(int level, uint32_t node, KnnQuery& query) const {
  float bounds[kFanout];
  uint32_t within = ChildBounds(level, node, query.point, query.limit2, bounds);
  if (level == 0) {
    for (; within != 0; within &= within - 1) {
      const int j = std::countr_zero(within);
      if (bounds[j] > query.limit2) continue;
      const uint32_t position = node * kFanout + j;
      const uint32_t row = order_[position];
      if (row == query.skip) continue;
      const double distance2 = Distance2(query.point, Point(position));
      if (query.CanImprove(distance2, row)) query.Add(distance2, row);
    }
    return;
  }
  KdChildOrder children(bounds, within);
  for (int j; (j = children.Next()) >= 0;) {
    if (bounds[j] > query.limit2) return;
    const uint32_t child = node * kFanout + j;
    if (MayTie(bounds[j], query.limit2) &&
        !query.CanImprove(BoxDistance2(level - 1, child, query.point),
                          MinRow(level - 1, child))) {
      continue;
    }
    Search(level - 1, child, query);
  }
}

void KdTree::Nearest(const float* query,
                     int k,
                     uint32_t skip,
                     std::vector<Neighbor>* result) const {
  result->clear();
  if (k <= 0 || order_.empty()) return;
  KnnQuery search{query, static_cast<size_t>(k), skip, *result};
  Search(num_levels() - 1, 0, search);
  std::sort_heap(result->begin(), result->end());
}

}  // namespace freegs
