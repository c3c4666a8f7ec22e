// SPDX-License-Identifier: BSD-3-Clause
// Separates things that touch: a book and the mug on it.

#ifndef FREEGS_SEMANTICS_INSTANCES_CREASE_SPLIT_H_
#define FREEGS_SEMANTICS_INSTANCES_CREASE_SPLIT_H_

#include <cstdint>
#include <span>
#include <vector>

#include "core/parallel.h"
#include "core/status.h"

namespace freegs::semantics {

struct CreaseSplitOptions {
  // Parts meet in a crease when their mean concavity (see below) times the
  // distance of their mean colours (RGB in [0, 1]) exceeds this; 0 splits
  // nothing.
  double min_contrast = 0.12;

  // Size of the patches that parts are made of, in the units of positions.
  double patch_size = 0.05;

  // Parts of fewer points are joined to a neighbour.
  int min_part_size = 200;

  Status Check() const;
};

// Things that touch meet in a concave crease and, mostly, differ in colour;
// neither is enough alone: a bear's neck is concave, a ball's stripes differ.
//
// Each cluster is cut into patches of like position, colour and normal
// (supervoxels: Papon et al. 2013), which are then joined pair by pair, the
// pair of least contrast first, until all pairs of touching parts contrast. The
// concavity of two patches with centres c and outward normals n is (n_b - n_a)
// . (c_a - c_b) / |c_a - c_b|, positive in a concave crease (Stein et al.
// 2014); of two parts, its mean over touching patches, weighted by the length
// of contact.
//
// positions, colors, normals: N x 3, normals unit and outward. labels: N, -1
// for none; parts get new labels (the largest keeps the cluster's).
void SplitAtCreases(std::span<const float> positions,
                    std::span<const float> colors,
                    std::span<const float> normals,
                    const CreaseSplitOptions& options,
                    ThreadPool& pool,
                    std::vector<int32_t>* labels);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_INSTANCES_CREASE_SPLIT_H_
