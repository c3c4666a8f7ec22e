// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/hdbscan/mutual_reachability_mst.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

#include "core/disjoint_sets.h"
#include "semantics/hdbscan/component_edges.h"
#include "semantics/hdbscan/component_filters.h"

namespace freegs::semantics {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr uint32_t kNone = 0xffffffffu;
constexpr int64_t kGrain = 128;

// What is known of the shortest edges from a point to other components, apart
// from those to the points on its list of neighbours.
struct PointState {
  uint32_t candidate = kNone;  // Other end of the shortest edge found.
  double candidate2 = kInfinity;
  double rest2 = 0;  // Lower bound of all other such edges.
};

class Boruvka {
 public:
  Boruvka(const KdTree& tree, const CoreDistances& cores, ThreadPool& pool)
      : tree_(tree), cores_(cores), pool_(pool), filters_(tree, cores.core2) {
    const size_t count = tree.size();
    component_.resize(ComponentFilters::RoundUp(count));
    std::iota(component_.begin(), component_.end(), 0u);
    num_components_ = static_cast<uint32_t>(count);
    position_of_row_.resize(count);
    states_.resize(count);
    for (size_t p = 0; p < count; ++p) {
      position_of_row_[tree.Row(p)] = static_cast<uint32_t>(p);
      states_[p].rest2 = cores.last2[p];
    }
    undecided_.resize(count);
    list_done_.resize(count);
  }

  StatusOr<std::vector<MstEdge>> Run(const CancellationToken* cancellation) {
    cancellation_ = cancellation;
    std::vector<MstEdge> mst;
    mst.reserve(tree_.size());
    while (num_components_ > 1) {
      BestEdges best(num_components_);
      filters_.Update(component_);
      SearchLists(best);
      SearchTree(best);
      if (IsCancelled(cancellation_)) {
        return InterruptedError("clustering was interrupted");
      }
      Merge(best, mst);
    }
    std::sort(mst.begin(), mst.end());
    return mst;
  }

 private:
  double Weight2(uint32_t p, uint32_t q) const {
    return std::max({cores_.core2[p],
                     cores_.core2[q],
                     tree_.Distance2(tree_.Point(p), tree_.Point(q))});
  }

  // The shortest edge from a point to a point on its list that is in another
  // component.
  MstEdge LeastListed(int64_t p) {
    if (list_done_[p]) return kNoEdge;
    const int size = cores_.list_size;
    const uint32_t* list = cores_.neighbors.data() + p * size;
    MstEdge least = kNoEdge;
    for (int j = 0; j < size; ++j) {
      const uint32_t q = list[j];
      if (component_[q] == component_[p]) continue;
      // All but the last are within p's core distance.
      const double weight2 = j < size - 1
                                 ? std::max(cores_.core2[p], cores_.core2[q])
                                 : Weight2(p, q);
      least = std::min(least, MakeEdge(weight2, tree_.Row(p), tree_.Row(q)));
    }
    list_done_[p] = least == kNoEdge;
    return least;
  }

  // The edge that an earlier search of the tree found, unless both ends are in
  // one component by now.
  MstEdge Candidate(uint32_t p) {
    PointState& state = states_[p];
    if (state.candidate == kNone) return kNoEdge;
    if (component_[state.candidate] == component_[p]) {
      state.candidate = kNone;
      state.candidate2 = kInfinity;
      return kNoEdge;
    }
    return MakeEdge(state.candidate2, tree_.Row(p), tree_.Row(state.candidate));
  }

  // Offers the best edge that every point knows, and notes which points may
  // have a better one.
  void SearchLists(BestEdges& best) {
    pool_.ParallelFor(
        0, tree_.size(), 1024, [&](int64_t first, int64_t last, int) {
          for (int64_t p = first; p < last; ++p) {
            undecided_[p] = 0;
            if (component_[p] == passive_) continue;
            MstEdge least = LeastListed(p);
            least = std::min(least, Candidate(p));
            if (least.weight2 < kInfinity) best.Offer(component_[p], least);
            undecided_[p] = !(least.weight2 < states_[p].rest2);
          }
        });
  }

  void SearchTree(BestEdges& best) {
    pool_.ParallelFor(
        0, tree_.size(), kGrain, [&](int64_t first, int64_t last, int) {
          if (IsCancelled(cancellation_)) return;
          for (int64_t p = first; p < last; ++p) {
            if (!undecided_[p] || states_[p].rest2 == kInfinity) continue;
            const uint32_t own = component_[p];
            if (states_[p].rest2 > best.Weight2(own)) continue;
            Query query{.position = static_cast<uint32_t>(p),
                        .component = own,
                        .floor2 = states_[p].rest2,
                        .found = best.Get(own),
                        .best = best,
                        .state = states_[p]};
            query.state.rest2 = kInfinity;
            const MstEdge before = query.found;
            Search(tree_.num_levels() - 1, 0, query);
            if (query.found < before) best.Offer(own, query.found);
            if (query.state.candidate == states_[p].candidate ||
                states_[p].candidate == kNone) {
              query.state.rest2 = std::max(query.state.rest2, query.floor2);
            }
            states_[p] = query.state;
          }
        });
  }

  struct Query {
    uint32_t position;
    uint32_t component;
    double floor2;  // Lower bound of all edges but listed ones and candidate.
    MstEdge found;  // The shortest edge known of this point or component.
    BestEdges& best;
    PointState state;

    double Limit2() const {
      return std::min(found.weight2, best.Weight2(component));
    }
    void Leave(double weight2) { state.rest2 = std::min(state.rest2, weight2); }
  };

  void Search(int level, uint32_t node, Query& query) const {
    const float* point = tree_.Point(query.position);
    const size_t first = static_cast<size_t>(node) * KdTree::kFanout;
    float bounds[KdTree::kFanout];
    const KdBlockBounds children =
        tree_.ChildBounds(level,
                          node,
                          point,
                          filters_.At(level, node, query.component),
                          query.Limit2(),
                          bounds);
    query.Leave(children.least_beyond);
    KdChildOrder order(bounds, children.within);
    for (int j; (j = order.Next()) >= 0;) {
      if (bounds[j] > query.Limit2()) {
        query.Leave(bounds[j]);
        return;
      }
      const auto child = static_cast<uint32_t>(first + j);
      if (level == 0) {
        Weigh(child, query);
      } else if (CanImprove(level - 1, child, bounds[j], query)) {
        Search(level - 1, child, query);
      }
    }
  }

  // Whether an edge to a point of the node may come before the best edge. Rows
  // decide between equal weights.
  bool CanImprove(int level, uint32_t node, float bound, Query& query) const {
    if (!tree_.MayTie(bound, query.Limit2())) return true;
    const float* point = tree_.Point(query.position);
    const double bound2 = std::max({tree_.BoxDistance2(level, node, point),
                                    static_cast<double>(bound),
                                    query.floor2});
    if (MakeEdge(bound2, tree_.Row(query.position), tree_.MinRow(level, node)) <
        query.found) {
      return true;
    }
    query.Leave(bound2);
    return false;
  }

  void Weigh(uint32_t q, Query& query) const {
    if (q == query.state.candidate) return;
    const double weight2 = Weight2(query.position, q);
    const MstEdge edge =
        MakeEdge(weight2, tree_.Row(query.position), tree_.Row(q));
    if (edge < query.found) query.found = edge;
    if (weight2 < query.state.candidate2) {
      query.Leave(query.state.candidate2);
      query.state.candidate = q;
      query.state.candidate2 = weight2;
    } else {
      query.Leave(weight2);
    }
  }

  void Merge(BestEdges& best, std::vector<MstEdge>& mst) {
    DisjointSets merged(num_components_);
    for (uint32_t c = 0; c < num_components_; ++c) {
      if (c == passive_) continue;
      const MstEdge edge = best.Get(c);
      // The other component may have chosen the same edge.
      if (merged.Join(component_[position_of_row_[edge.a]],
                      component_[position_of_row_[edge.b]])) {
        mst.push_back(edge);
      }
    }
    std::vector<uint32_t> renumbered(num_components_);
    uint32_t next = 0;
    for (uint32_t c = 0; c < num_components_; ++c) {
      const uint32_t root = merged.Find(c);
      renumbered[c] = root == c ? next++ : renumbered[root];
    }
    num_components_ = next;
    std::vector<uint32_t> sizes(num_components_, 0);
    for (size_t p = 0; p < tree_.size(); ++p) {
      component_[p] = renumbered[component_[p]];
      ++sizes[component_[p]];
    }
    passive_ = static_cast<uint32_t>(
        std::max_element(sizes.begin(), sizes.end()) - sizes.begin());
  }

  const KdTree& tree_;
  const CoreDistances& cores_;
  ThreadPool& pool_;
  ComponentFilters filters_;
  const CancellationToken* cancellation_ = nullptr;

  // By tree position.
  std::vector<uint32_t> component_;
  std::vector<PointState> states_;
  std::vector<uint8_t> undecided_;
  std::vector<uint8_t> list_done_;  // The whole list is in the component.
  std::vector<uint32_t> position_of_row_;

  uint32_t num_components_ = 0;
  // The largest component lets the others find their edges to it.
  uint32_t passive_ = kNone;
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
