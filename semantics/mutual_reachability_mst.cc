// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/mutual_reachability_mst.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <limits>
#include <mutex>
#include <numeric>
#include <utility>

namespace freegs::semantics {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr uint32_t kMixed = 0xffffffffu;
constexpr int64_t kGrain = 128;

constexpr MstEdge kNoEdge{kInfinity, 0xffffffffu, 0xffffffffu};

MstEdge MakeEdge(double weight2, uint32_t a, uint32_t b) {
  return a < b ? MstEdge{weight2, a, b} : MstEdge{weight2, b, a};
}

// The least edge each component has found so far in a round. The weight alone
// is read without a lock: a stale value only prunes less.
class BestEdges {
 public:
  explicit BestEdges(size_t num_components)
      : edges_(num_components, kNoEdge), weights_(num_components) {
    for (auto& weight : weights_) weight.store(kInfinity);
  }

  double Weight2(uint32_t component) const {
    return weights_[component].load(std::memory_order_relaxed);
  }

  MstEdge Get(uint32_t component) {
    const std::lock_guard lock(MutexOf(component));
    return edges_[component];
  }

  void Offer(uint32_t component, const MstEdge& edge) {
    if (edge.weight2 > Weight2(component)) return;
    const std::lock_guard lock(MutexOf(component));
    if (edge < edges_[component]) {
      edges_[component] = edge;
      weights_[component].store(edge.weight2, std::memory_order_relaxed);
    }
  }

 private:
  std::mutex& MutexOf(uint32_t component) {
    return mutexes_[component % mutexes_.size()];
  }

  std::vector<MstEdge> edges_;
  std::vector<std::atomic<double>> weights_;
  std::array<std::mutex, 64> mutexes_;
};

class Boruvka {
 public:
  Boruvka(const KdTree& tree, const CoreDistances& cores, ThreadPool& pool)
      : tree_(tree), cores_(cores), pool_(pool) {
    const size_t count = tree.size();
    component_.resize(count);
    std::iota(component_.begin(), component_.end(), 0u);
    num_components_ = static_cast<uint32_t>(count);
    position_of_row_.resize(count);
    for (size_t p = 0; p < count; ++p) {
      position_of_row_[tree.Row(p)] = static_cast<uint32_t>(p);
    }
    foreign2_ = cores.core2;
    undecided_.resize(count);
    node_component_.resize(tree.nodes().size());
    InitMinCore();
  }

  StatusOr<std::vector<MstEdge>> Run(const CancellationToken* cancellation) {
    cancellation_ = cancellation;
    std::vector<MstEdge> mst;
    mst.reserve(tree_.size());
    while (num_components_ > 1) {
      BestEdges best(num_components_);
      UpdateNodeComponents();
      SearchLists(best);
      SearchTree(best);
      if (Cancelled()) return InterruptedError("clustering was interrupted");
      Merge(best, mst);
    }
    std::sort(mst.begin(), mst.end());
    return mst;
  }

 private:
  bool Cancelled() const {
    return cancellation_ != nullptr && cancellation_->cancelled();
  }

  void InitMinCore() {
    const auto& nodes = tree_.nodes();
    node_min_core2_.resize(nodes.size());
    for (size_t id = nodes.size(); id-- > 0;) {
      const KdTree::Node& node = nodes[id];
      node_min_core2_[id] =
          node.is_leaf()
              ? *std::min_element(cores_.core2.begin() + node.begin,
                                  cores_.core2.begin() + node.end)
              : std::min(node_min_core2_[id + 1], node_min_core2_[node.right]);
    }
  }

  void UpdateNodeComponents() {
    const auto& nodes = tree_.nodes();
    for (size_t id = nodes.size(); id-- > 0;) {
      const KdTree::Node& node = nodes[id];
      if (!node.is_leaf()) {
        const uint32_t left = node_component_[id + 1];
        node_component_[id] =
            left == node_component_[node.right] ? left : kMixed;
        continue;
      }
      uint32_t common = component_[node.begin];
      for (uint32_t p = node.begin + 1; p < node.end; ++p) {
        if (component_[p] != common) {
          common = kMixed;
          break;
        }
      }
      node_component_[id] = common;
    }
  }

  // Offers the best listed edge of every point and notes which points may have
  // a better one outside their list.
  void SearchLists(BestEdges& best) {
    const int size = cores_.list_size;
    pool_.ParallelFor(
        0, component_.size(), 1024, [&](int64_t first, int64_t last, int) {
          for (int64_t p = first; p < last; ++p) {
            const uint32_t own = component_[p];
            const uint32_t* list = cores_.neighbors.data() + p * size;
            MstEdge found = kNoEdge;
            for (int j = 0; j < size; ++j) {
              const uint32_t q = list[j];
              if (component_[q] == own) continue;
              double weight2 = std::max(cores_.core2[p], cores_.core2[q]);
              // All but the last are within p's core distance.
              if (j == size - 1) {
                weight2 = std::max(
                    weight2, tree_.Distance2(tree_.Point(p), tree_.Point(q)));
              }
              found = std::min(found,
                               MakeEdge(weight2, tree_.Row(p), tree_.Row(q)));
            }
            if (found.weight2 < kInfinity) best.Offer(own, found);
            // Unlisted points are at last2 or farther.
            undecided_[p] = !(found.weight2 < cores_.last2[p]);
            if (found.weight2 == kInfinity) {
              foreign2_[p] = std::max(foreign2_[p], cores_.last2[p]);
            }
          }
        });
  }

  void SearchTree(BestEdges& best) {
    pool_.ParallelFor(
        0, component_.size(), kGrain, [&](int64_t first, int64_t last, int) {
          if (Cancelled()) return;
          for (int64_t p = first; p < last; ++p) {
            if (!undecided_[p] || cores_.last2[p] == kInfinity) continue;
            const uint32_t own = component_[p];
            if (foreign2_[p] > best.Weight2(own)) continue;
            Query query{.point = tree_.Point(p),
                        .row = tree_.Row(p),
                        .component = own,
                        .core2 = cores_.core2[p],
                        .found = best.Get(own),
                        .best = best};
            const MstEdge before = query.found;
            Search(0, query);
            if (query.found < before) best.Offer(own, query.found);
            // Every foreign point was either weighed or pruned by a bound.
            foreign2_[p] = std::max(foreign2_[p], query.least2);
          }
        });
  }

  struct Query {
    const float* point;
    uint32_t row;
    uint32_t component;
    double core2;
    MstEdge found;  // The least edge known, of this point or its component.
    BestEdges& best;
    double least2 = kInfinity;  // Least weight or bound of what was visited.

    // Whether an edge of at least this weight to a row of at least this number
    // could be less than the best.
    bool CanImprove(double weight2, uint32_t min_row) {
      if (weight2 <= best.Weight2(component) &&
          MakeEdge(weight2, row, min_row) < found) {
        return true;
      }
      least2 = std::min(least2, weight2);
      return false;
    }
  };

  double NodeBound2(uint32_t id, const Query& query) const {
    return std::max({tree_.BoxDistance2(id, query.point),
                     node_min_core2_[id],
                     query.core2});
  }

  void Search(uint32_t id, Query& query) const {
    if (node_component_[id] == query.component) return;
    const KdTree::Node& node = tree_.nodes()[id];
    if (node.is_leaf()) {
      SearchLeaf(node, query);
      return;
    }
    uint32_t near = id + 1;
    uint32_t far = node.right;
    double near2 = node_component_[near] == query.component
                       ? kInfinity
                       : NodeBound2(near, query);
    double far2 = node_component_[far] == query.component
                      ? kInfinity
                      : NodeBound2(far, query);
    if (far2 < near2 || (far2 == near2 && tree_.nodes()[far].min_index <
                                              tree_.nodes()[near].min_index)) {
      std::swap(near, far);
      std::swap(near2, far2);
    }
    if (query.CanImprove(near2, tree_.nodes()[near].min_index)) {
      Search(near, query);
    }
    if (query.CanImprove(far2, tree_.nodes()[far].min_index)) {
      Search(far, query);
    }
  }

  void SearchLeaf(const KdTree::Node& leaf, Query& query) const {
    float bounds[KdTree::kLeafSize];
    tree_.LeafLowerBounds(leaf, query.point, bounds);
    for (uint32_t q = leaf.begin; q < leaf.end; ++q) {
      if (component_[q] == query.component) continue;
      const double bound2 =
          std::max({static_cast<double>(bounds[q - leaf.begin]),
                    cores_.core2[q],
                    query.core2});
      const uint32_t row = tree_.Row(q);
      if (!query.CanImprove(bound2, row)) continue;
      const double weight2 =
          std::max(bound2, tree_.Distance2(query.point, tree_.Point(q)));
      query.least2 = std::min(query.least2, weight2);
      const MstEdge edge = MakeEdge(weight2, query.row, row);
      if (edge < query.found) query.found = edge;
    }
  }

  uint32_t Find(std::vector<uint32_t>& parent, uint32_t x) const {
    while (parent[x] != x) {
      parent[x] = parent[parent[x]];
      x = parent[x];
    }
    return x;
  }

  void Merge(BestEdges& best, std::vector<MstEdge>& mst) {
    std::vector<uint32_t> parent(num_components_);
    std::iota(parent.begin(), parent.end(), 0u);
    for (uint32_t c = 0; c < num_components_; ++c) {
      const MstEdge edge = best.Get(c);
      const uint32_t a = Find(parent, component_[position_of_row_[edge.a]]);
      const uint32_t b = Find(parent, component_[position_of_row_[edge.b]]);
      if (a == b) continue;  // The other side chose the same edge.
      parent[std::max(a, b)] = std::min(a, b);
      mst.push_back(edge);
    }
    std::vector<uint32_t> renumbered(num_components_);
    uint32_t next = 0;
    for (uint32_t c = 0; c < num_components_; ++c) {
      const uint32_t root = Find(parent, c);
      renumbered[c] = root == c ? next++ : renumbered[root];
    }
    for (uint32_t& c : component_) c = renumbered[c];
    num_components_ = next;
  }

  const KdTree& tree_;
  const CoreDistances& cores_;
  ThreadPool& pool_;
  const CancellationToken* cancellation_ = nullptr;

  // By tree position.
  std::vector<uint32_t> component_;
  std::vector<double> foreign2_;  // No edge out of the component is lighter.
  std::vector<uint8_t> undecided_;
  std::vector<uint32_t> position_of_row_;
  // By tree node.
  std::vector<uint32_t> node_component_;  // kMixed where several.
  std::vector<double> node_min_core2_;

  uint32_t num_components_ = 0;
};

}  // namespace

StatusOr<std::vector<MstEdge>> MutualReachabilityMst(
    const KdTree& tree,
    const CoreDistances& cores,
    ThreadPool& pool,
    const CancellationToken* cancellation) {
  if (tree.size() < 2) return std::vector<MstEdge>();
  return Boruvka(tree, cores, pool).Run(cancellation);
}

}  // namespace freegs::semantics
