// SPDX-License-Identifier: BSD-3-Clause
// From a minimum spanning tree to flat clusters: single linkage, condensed
// tree, stability, selection (Campello, Moulavi and Sander 2013; McInnes and
// Healy 2017), with the conventions of scikit-learn-contrib/hdbscan.

#ifndef FREEGS_SEMANTICS_HDBSCAN_CLUSTER_HIERARCHY_H_
#define FREEGS_SEMANTICS_HDBSCAN_CLUSTER_HIERARCHY_H_

#include <cstdint>
#include <span>
#include <vector>

#include "semantics/hdbscan/mutual_reachability_mst.h"

namespace freegs::semantics {

// The dendrogram without splits that shed fewer than min_cluster_size points.
// Clusters are numbered so that parents come before children; 0 is the root,
// which holds all points.
struct CondensedTree {
  struct Cluster {
    uint32_t parent = 0;      // The root is its own parent.
    double birth_lambda = 0;  // 1 / distance at which it split off.
    double max_lambda = 0;    // When its last point or child left it.
    uint32_t size = 0;        // Points at birth.
    double stability = 0;     // Sum over points of (leaving - birth) lambda.
    std::vector<uint32_t> children;  // None or two.
  };
  std::vector<Cluster> clusters;

  // Per point: the cluster it left as a single point, and at what lambda.
  std::vector<uint32_t> point_cluster;
  std::vector<double> point_lambda;
};

// mst: the num_points - 1 edges in ascending order. min_cluster_size >= 2.
// Lambdas of edges of length 0 are infinite.
CondensedTree CondenseTree(std::span<const MstEdge> mst,
                           size_t num_points,
                           int min_cluster_size);

enum class ClusterSelection {
  kExcessOfMass,  // The set of clusters with the largest total stability.
  kLeaf,          // The leaves of the condensed tree: finer, more even.
};

struct ClusterSelectionOptions {
  ClusterSelection method = ClusterSelection::kExcessOfMass;

  // Clusters that split off below this distance are merged into the first
  // ancestor that did not (below the root). 0 merges nothing.
  double epsilon = 0;

  // Excess of mass splits clusters larger than this; epsilon may still exceed
  // it. 0 means no limit.
  int64_t max_cluster_size = 0;

  // Excess of mass prefers two neighbours as one cluster when all else is far
  // away, however clear the gap between them. Where this is above 0, selected
  // clusters are split further as long as both parts are farther from each
  // other than this many times the mean distance within them (the mean over
  // points of the distance at which they leave the cluster or its descendants).
  // Not part of HDBSCAN.
  double min_gap_ratio = 0;
};

// Ids of the selected clusters, ascending; disjoint, and never the root. A
// cluster is split only if the stabilities of its children, summed and rounded
// to float, exceed its own in double: a convention of the reference.
std::vector<uint32_t> SelectClusters(const CondensedTree& tree,
                                     const ClusterSelectionOptions& options);

// Per point: index into `selected` of the cluster that holds it, or -1; and how
// firmly (point lambda over the cluster's largest, at most 1; 0 for -1).
struct ClusterMembership {
  std::vector<int32_t> labels;
  std::vector<float> probabilities;
};
ClusterMembership LabelPoints(const CondensedTree& tree,
                              std::span<const uint32_t> selected);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_HDBSCAN_CLUSTER_HIERARCHY_H_
