// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/hdbscan/cluster_hierarchy.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/disjoint_sets.h"

namespace freegs::semantics {
namespace {

// A merge of the single-linkage dendrogram. Nodes below num_points are points,
// node num_points + i is merge i.
struct Merge {
  uint32_t left;
  uint32_t right;
  double distance2;
  uint32_t size;
};

std::vector<Merge> SingleLinkage(std::span<const MstEdge> mst,
                                 size_t num_points) {
  DisjointSets sets(num_points);
  // The dendrogram node and the size of each set, stored at the smallest
  // member of the set.
  std::vector<uint32_t> node(num_points);
  std::iota(node.begin(), node.end(), 0u);
  std::vector<uint32_t> size(num_points, 1);
  std::vector<Merge> merges;
  merges.reserve(mst.size());
  for (const MstEdge& edge : mst) {
    const uint32_t a = sets.Find(edge.a);
    const uint32_t b = sets.Find(edge.b);
    merges.push_back({node[a], node[b], edge.weight2, size[a] + size[b]});
    sets.Join(a, b);
    size[std::min(a, b)] = merges.back().size;
    node[std::min(a, b)] =
        static_cast<uint32_t>(num_points + merges.size() - 1);
  }
  return merges;
}

double Lambda(double distance2) {
  return distance2 > 0 ? 1.0 / std::sqrt(distance2)
                       : std::numeric_limits<double>::infinity();
}

}  // namespace

CondensedTree CondenseTree(std::span<const MstEdge> mst,
                           size_t num_points,
                           int min_cluster_size) {
  CondensedTree tree;
  tree.point_cluster.assign(num_points, 0);
  tree.point_lambda.assign(num_points, 0.0);
  tree.clusters.emplace_back();
  tree.clusters[0].size = static_cast<uint32_t>(num_points);
  if (num_points < 2) return tree;

  const std::vector<Merge> merges = SingleLinkage(mst, num_points);
  const auto size_of = [&](uint32_t node) {
    return node < num_points ? 1u : merges[node - num_points].size;
  };
  const auto leave = [&](uint32_t cluster, double lambda, uint32_t count) {
    CondensedTree::Cluster& from = tree.clusters[cluster];
    from.stability += (lambda - from.birth_lambda) * count;
    from.max_lambda = std::max(from.max_lambda, lambda);
  };
  // All points below the node leave the cluster one by one.
  std::vector<uint32_t> stack;
  const auto shed = [&](uint32_t node, uint32_t cluster, double lambda) {
    stack.assign(1, node);
    while (!stack.empty()) {
      const uint32_t current = stack.back();
      stack.pop_back();
      if (current < num_points) {
        tree.point_cluster[current] = cluster;
        tree.point_lambda[current] = lambda;
        leave(cluster, lambda, 1);
      } else {
        stack.push_back(merges[current - num_points].right);
        stack.push_back(merges[current - num_points].left);
      }
    }
  };

  // Breadth first, so that clusters are numbered parents first.
  struct Visit {
    uint32_t node;
    uint32_t cluster;
  };
  std::vector<Visit> queue;
  queue.push_back({static_cast<uint32_t>(2 * num_points - 2), 0});
  const auto min_size = static_cast<uint32_t>(std::max(2, min_cluster_size));
  for (size_t i = 0; i < queue.size(); ++i) {
    const auto [node, cluster] = queue[i];
    const Merge& merge = merges[node - num_points];
    const double lambda = Lambda(merge.distance2);
    const uint32_t sides[2] = {merge.left, merge.right};
    const bool large[2] = {size_of(merge.left) >= min_size,
                           size_of(merge.right) >= min_size};
    for (int side = 0; side < 2; ++side) {
      if (!large[side]) {
        shed(sides[side], cluster, lambda);
      } else if (!large[1 - side]) {
        queue.push_back({sides[side], cluster});
      } else {
        const auto child = static_cast<uint32_t>(tree.clusters.size());
        const uint32_t size = size_of(sides[side]);
        leave(cluster, lambda, size);
        tree.clusters[cluster].children.push_back(child);
        CondensedTree::Cluster born;
        born.parent = cluster;
        born.birth_lambda = lambda;
        born.size = size;
        tree.clusters.push_back(std::move(born));
        queue.push_back({sides[side], child});
      }
    }
  }
  return tree;
}

namespace {

// Sets `selected` for the clusters below (not including) `cluster`.
void DeselectBelow(const CondensedTree& tree,
                   uint32_t cluster,
                   std::vector<uint8_t>* selected) {
  std::vector<uint32_t> stack(tree.clusters[cluster].children);
  while (!stack.empty()) {
    const uint32_t current = stack.back();
    stack.pop_back();
    (*selected)[current] = 0;
    const auto& children = tree.clusters[current].children;
    stack.insert(stack.end(), children.begin(), children.end());
  }
}

std::vector<uint8_t> SelectExcessOfMass(const CondensedTree& tree,
                                        int64_t max_cluster_size) {
  std::vector<uint8_t> selected(tree.clusters.size(), 1);
  std::vector<double> best(tree.clusters.size());
  selected[0] = 0;
  for (size_t id = tree.clusters.size(); id-- > 1;) {
    const CondensedTree::Cluster& cluster = tree.clusters[id];
    double sum = 0;
    for (const uint32_t child : cluster.children) sum += best[child];
    const float children_stability = static_cast<float>(sum);
    const bool too_large =
        max_cluster_size > 0 && cluster.size > max_cluster_size;
    if (children_stability > cluster.stability || too_large) {
      selected[id] = 0;
      best[id] = children_stability;
    } else {
      best[id] = cluster.stability;
    }
  }
  // The topmost selected cluster of each branch wins.
  for (uint32_t id = 1; id < tree.clusters.size(); ++id) {
    if (selected[id]) DeselectBelow(tree, id, &selected);
  }
  return selected;
}

}  // namespace

std::vector<uint32_t> SelectClusters(const CondensedTree& tree,
                                     const ClusterSelectionOptions& options) {
  std::vector<uint8_t> selected;
  if (options.method == ClusterSelection::kExcessOfMass) {
    selected = SelectExcessOfMass(tree, options.max_cluster_size);
  } else {
    selected.resize(tree.clusters.size());
    for (size_t id = 1; id < tree.clusters.size(); ++id) {
      selected[id] = tree.clusters[id].children.empty();
    }
  }
  if (options.epsilon > 0) {
    const auto born_below_epsilon = [&](uint32_t id) {
      return 1.0 / tree.clusters[id].birth_lambda < options.epsilon;
    };
    for (uint32_t id = 1; id < tree.clusters.size(); ++id) {
      if (!selected[id] || !born_below_epsilon(id)) continue;
      // The climb goes on past an ancestor that was born exactly at epsilon.
      uint32_t top = id;
      while (tree.clusters[top].parent != 0) {
        top = tree.clusters[top].parent;
        if (1.0 / tree.clusters[top].birth_lambda > options.epsilon) break;
      }
      selected[top] = 1;
      DeselectBelow(tree, top, &selected);
    }
  }
  std::vector<uint32_t> ids;
  for (uint32_t id = 1; id < selected.size(); ++id) {
    if (selected[id]) ids.push_back(id);
  }
  return ids;
}

ClusterMembership LabelPoints(const CondensedTree& tree,
                              std::span<const uint32_t> selected) {
  std::vector<int32_t> label_of_cluster(tree.clusters.size(), -1);
  for (size_t i = 0; i < selected.size(); ++i) {
    label_of_cluster[selected[i]] = static_cast<int32_t>(i);
  }
  for (size_t id = 1; id < tree.clusters.size(); ++id) {
    if (label_of_cluster[id] < 0) {
      label_of_cluster[id] = label_of_cluster[tree.clusters[id].parent];
    }
  }
  ClusterMembership result;
  const size_t count = tree.point_cluster.size();
  result.labels.resize(count);
  result.probabilities.assign(count, 0.0f);
  for (size_t i = 0; i < count; ++i) {
    const int32_t label = label_of_cluster[tree.point_cluster[i]];
    result.labels[i] = label;
    if (label < 0) continue;
    const double max_lambda = tree.clusters[selected[label]].max_lambda;
    const double lambda = tree.point_lambda[i];
    result.probabilities[i] =
        max_lambda == 0 || !std::isfinite(lambda)
            ? 1.0f
            : static_cast<float>(std::min(lambda, max_lambda) / max_lambda);
  }
  return result;
}

}  // namespace freegs::semantics
