// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/kd_tree.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace freegs::semantics {
namespace {

// Relative error of a float sum of dim squared float differences is at most
// about (dim + 2) * 2^-24; this leaves room up to 80 dimensions and grows
// above.
float LowerBoundFactor(int dim) {
  return 1.0f - std::max(80, dim + 16) * 0x1p-23f;
}

}  // namespace

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
  tree.order_.resize(count);
  std::iota(tree.order_.begin(), tree.order_.end(), 0u);
  if (count == 0) return tree;
  const size_t max_nodes = 4 * (count / kLeafSize + 1);
  tree.nodes_.reserve(max_nodes);
  tree.boxes_.reserve(max_nodes * 2 * dim);
  tree.Build(0, static_cast<uint32_t>(count), points);

  tree.rows_.resize(points.size());
  for (size_t position = 0; position < count; ++position) {
    std::copy_n(
        points.data() + static_cast<size_t>(tree.order_[position]) * dim,
        dim,
        tree.rows_.data() + position * dim);
  }
  tree.block_.resize(tree.nodes_.size(), 0);
  uint32_t num_blocks = 0;
  for (size_t i = 0; i < tree.nodes_.size(); ++i) {
    if (tree.nodes_[i].is_leaf()) tree.block_[i] = num_blocks++;
  }
  tree.blocks_.resize(static_cast<size_t>(num_blocks) * dim * kLeafSize, 0.0f);
  for (size_t i = 0; i < tree.nodes_.size(); ++i) {
    const Node& node = tree.nodes_[i];
    if (!node.is_leaf()) continue;
    float* block = tree.blocks_.data() +
                   static_cast<size_t>(tree.block_[i]) * dim * kLeafSize;
    for (uint32_t position = node.begin; position < node.end; ++position) {
      for (int k = 0; k < dim; ++k) {
        block[k * kLeafSize + position - node.begin] = tree.Point(position)[k];
      }
    }
  }
  return tree;
}

void KdTree::Build(uint32_t begin,
                   uint32_t end,
                   std::span<const float> points) {
  const size_t id = nodes_.size();
  const auto point = [&](uint32_t row) {
    return points.data() + static_cast<size_t>(row) * dim_;
  };
  Node node;
  node.begin = begin;
  node.end = end;
  node.min_index =
      *std::min_element(order_.begin() + begin, order_.begin() + end);
  nodes_.push_back(node);
  boxes_.resize(boxes_.size() + 2 * dim_);
  {
    float* low = boxes_.data() + id * 2 * dim_;
    float* high = low + dim_;
    std::copy_n(point(order_[begin]), dim_, low);
    std::copy_n(point(order_[begin]), dim_, high);
    for (uint32_t position = begin + 1; position < end; ++position) {
      const float* p = point(order_[position]);
      for (int k = 0; k < dim_; ++k) {
        low[k] = std::min(low[k], p[k]);
        high[k] = std::max(high[k], p[k]);
      }
    }
  }
  if (end - begin <= kLeafSize) return;
  const float* low = boxes_.data() + id * 2 * dim_;
  const float* high = low + dim_;
  int widest = 0;
  for (int k = 1; k < dim_; ++k) {
    if (high[k] - low[k] > high[widest] - low[widest]) widest = k;
  }
  // Equal coordinates are split by row: the depth stays logarithmic whatever
  // the points, and among duplicates the left child holds the smaller rows.
  const uint32_t middle = begin + (end - begin) / 2;
  std::nth_element(order_.begin() + begin,
                   order_.begin() + middle,
                   order_.begin() + end,
                   [&](uint32_t a, uint32_t b) {
                     const float xa = point(a)[widest];
                     const float xb = point(b)[widest];
                     return xa != xb ? xa < xb : a < b;
                   });
  Build(begin, middle, points);
  nodes_[id].right = static_cast<uint32_t>(nodes_.size());
  Build(middle, end, points);
}

void KdTree::LeafLowerBounds(const Node& leaf,
                             const float* query,
                             float bounds[kLeafSize]) const {
  const size_t id = &leaf - nodes_.data();
  const float* block =
      blocks_.data() + static_cast<size_t>(block_[id]) * dim_ * kLeafSize;
  float sums[kLeafSize] = {};
  for (int k = 0; k < dim_; ++k) {
    const float center = query[k];
    for (int j = 0; j < kLeafSize; ++j) {
      const float difference = block[k * kLeafSize + j] - center;
      sums[j] += difference * difference;
    }
  }
  const float factor = LowerBoundFactor(dim_);
  for (int j = 0; j < kLeafSize; ++j) bounds[j] = sums[j] * factor;
}

// The best k found so far, as a heap with the worst on top.
struct KdTree::KnnQuery {
  const float* point;
  size_t k;
  uint32_t skip;
  std::vector<Neighbor>& heap;

  bool CanImprove(double distance2, uint32_t index) const {
    return heap.size() < k || Neighbor{distance2, index} < heap.front();
  }
  void Add(double distance2, uint32_t index) {
    if (heap.size() == k) {
      std::pop_heap(heap.begin(), heap.end());
      heap.back() = {distance2, index};
    } else {
      heap.push_back({distance2, index});
    }
    std::push_heap(heap.begin(), heap.end());
  }
};

void KdTree::Search(uint32_t id, KnnQuery& query) const {
  const Node& node = nodes_[id];
  if (node.is_leaf()) {
    float bounds[kLeafSize];
    LeafLowerBounds(node, query.point, bounds);
    for (uint32_t position = node.begin; position < node.end; ++position) {
      if (query.heap.size() == query.k &&
          bounds[position - node.begin] > query.heap.front().distance2) {
        continue;
      }
      const uint32_t row = order_[position];
      if (row == query.skip) continue;
      const double distance2 = Distance2(query.point, Point(position));
      if (query.CanImprove(distance2, row)) query.Add(distance2, row);
    }
    return;
  }
  uint32_t near = id + 1;
  uint32_t far = node.right;
  Neighbor near_bound{BoxDistance2(near, query.point), nodes_[near].min_index};
  Neighbor far_bound{BoxDistance2(far, query.point), nodes_[far].min_index};
  if (far_bound < near_bound) {
    std::swap(near, far);
    std::swap(near_bound, far_bound);
  }
  if (query.CanImprove(near_bound.distance2, near_bound.index)) {
    Search(near, query);
  }
  if (query.CanImprove(far_bound.distance2, far_bound.index)) {
    Search(far, query);
  }
}

void KdTree::Nearest(const float* query,
                     int k,
                     uint32_t skip,
                     std::vector<Neighbor>* result) const {
  result->clear();
  if (k <= 0 || order_.empty()) return;
  KnnQuery search{query, static_cast<size_t>(k), skip, *result};
  Search(0, search);
  std::sort_heap(result->begin(), result->end());
}

}  // namespace freegs::semantics
