// SPDX-License-Identifier: BSD-3-Clause
// Joins regions many times with noise and keeps what most of the trees say.
// Greedy merging is chaotic: one pair joined sooner or later changes all that
// follows, so that two reconstructions of the same photographs end with other
// objects. What happens in most trees is no accident.

#ifndef FREEGS_SEMANTICS_PATCHES_TREE_CONSENSUS_H_
#define FREEGS_SEMANTICS_PATCHES_TREE_CONSENSUS_H_

#include <cstddef>

#include "core/parallel.h"
#include "core/status.h"
#include "semantics/patches/region_merging.h"

namespace freegs::semantics {

struct ConsensusOptions {
  int num_trees = 32;

  // Standard deviation of what is added to every difference, in log-odds.
  double noise = 1;

  // Is added to the mean heights: with noise, greedy merging joins too much,
  // because it picks the pairs whose noise is low.
  double lean = 0.5;

  // What the tree without noise joins below -sure is joined in all trees, and a
  // height beyond +-sure counts as +-sure in the mean.
  double sure = 4;

  // More blocks that touch others than this are not compared with each other,
  // for the matrix of their mean heights takes 4 max_blocks^2 bytes: the tree
  // without noise is followed farther.
  size_t max_blocks = 1000;

  Status Check() const;
};

// The tree of mean heights: the height of two regions is the mean over all
// trees of that at which they are joined, and regions are joined in the order
// of these (average linkage, weighted by pixels). Below -sure it is the tree
// without noise, the one of MergeRegions. The same for any number of threads.
StatusOr<RegionTree> MergeByConsensus(const RegionGraph& graph,
                                      const DifferenceFn& difference,
                                      const ConsensusOptions& options,
                                      ThreadPool& pool);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_PATCHES_TREE_CONSENSUS_H_
