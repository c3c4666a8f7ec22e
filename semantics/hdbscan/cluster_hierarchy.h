// SPDX-License-Identifier: BSD-3-Clause
// From a minimum spanning tree to flat clusters, in the steps of HDBSCAN:
// single linkage, condensed tree, stability and selection (Campello, Moulavi
// and Sander 2013; McInnes and Healy 2017). The conventions are those of
// scikit-learn-contrib/hdbscan.

#ifndef FREEGS_SEMANTICS_HDBSCAN_CLUSTER_HIERARCHY_H_
#define FREEGS_SEMANTICS_HDBSCAN_CLUSTER_HIERARCHY_H_

#include <cstdint>
#include <span>
#include <vector>

#include "semantics/hdbscan/mutual_reachability_mst.h"

namespace freegs::semantics {

// The tree of clusters that single linkage makes. A lambda is the inverse of a
// distance: as lambda grows, clusters lose points and split. A split counts
// only if both parts have min_cluster_size points; otherwise the smaller part
// leaves the cluster as single points. Parents come before their children;
// cluster 0 is the root, which holds all points.
struct CondensedTree {
  struct Cluster {
    uint32_t parent = 0;      // The root is its own parent.
    double birth_lambda = 0;  // Lambda at which it split off its parent.
    double max_lambda = 0;    // Lambda at which its last point or child left.
    uint32_t size = 0;        // Number of points at birth.
    double stability = 0;     // Sum over points of (leaving - birth) lambda.
    std::vector<uint32_t> children;  // None or two.
  };
  std::vector<Cluster> clusters;

  // For each point: the cluster that it left as a single point, and the lambda
  // at which it left.
  std::vector<uint32_t> point_cluster;
  std::vector<double> point_lambda;
};

// mst: the num_points - 1 edges in ascending order. min_cluster_size: at least
// 2. The lambda of an edge of length 0 is infinite.
CondensedTree CondenseTree(std::span<const MstEdge> mst,
                           size_t num_points,
                           int min_cluster_size);

enum class ClusterSelection {
  kExcessOfMass,  // The clusters of largest total stability.
  // The leaves of the condensed tree: smaller clusters. The program does not
  // use it, see HdbscanOptions.
  kLeaf,
};

struct ClusterSelectionOptions {
  ClusterSelection method = ClusterSelection::kExcessOfMass;

  // A cluster that split off at less than this distance is replaced by its
  // first ancestor that split off farther away, but never by the root. 0
  // replaces none.
  double epsilon = 0;

  // Excess of mass splits clusters of more points. `epsilon` may still make
  // larger ones. 0 is no limit.
  int64_t max_cluster_size = 0;
};

// Returns the ids of the selected clusters, ascending. They are disjoint, and
// the root is never one of them. Under excess of mass a cluster is split only
// if the stabilities of its children, summed and rounded to float, exceed its
// own stability in double; the reference does the same.
std::vector<uint32_t> SelectClusters(const CondensedTree& tree,
                                     const ClusterSelectionOptions& options);

// For each point: the index into `selected` of the cluster that holds it, or
// -1; and how firmly it belongs there. The probability is the lambda of the
// point over the largest of the cluster, at most 1; it is 0 for label -1.
struct ClusterMembership {
  std::vector<int32_t> labels;
  std::vector<float> probabilities;
};
ClusterMembership LabelPoints(const CondensedTree& tree,
                              std::span<const uint32_t> selected);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_HDBSCAN_CLUSTER_HIERARCHY_H_
