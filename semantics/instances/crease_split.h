// SPDX-License-Identifier: BSD-3-Clause
// Separates things that touch, such as a book and the mug on it.

#ifndef FREEGS_SEMANTICS_INSTANCES_CREASE_SPLIT_H_
#define FREEGS_SEMANTICS_INSTANCES_CREASE_SPLIT_H_

#include <cstdint>
#include <span>
#include <vector>

#include "core/parallel.h"
#include "core/status.h"

namespace freegs::semantics {

struct CreaseSplitOptions {
  // Parts are separated where their mean concavity (see SplitAtCreases) times
  // the distance between their mean colours (RGB in [0, 1]) exceeds this. 0
  // separates nothing.
  double min_contrast = 0.12;

  // Size of the patches that parts are built from, in the units of the
  // positions.
  double patch_size = 0.05;

  // A part of fewer points is joined to a neighbour.
  int min_part_size = 200;

  Status Check() const;
};

// Things that touch meet in a concave crease, and they mostly differ in colour.
// Neither sign is enough alone: the neck of a bear is concave, and the stripes
// of a ball differ in colour.
//
// Each cluster is cut into patches of similar position, colour and normal
// (supervoxels; Papon et al. 2013). Patches are then joined pair by pair, the
// pair of least contrast first, until all parts that touch contrast with each
// other. For two patches with centres c and outward normals n the concavity is
// (n_b - n_a) . (c_a - c_b) / |c_a - c_b|. It is positive in a concave crease
// (Stein et al. 2014). The concavity of two parts is its mean over the patches
// that touch, weighted by the length of the contact.
//
// positions, colors, normals: N x 3; the normals have length 1 and point
// outward. labels: N, -1 for none; changed in place. The largest part keeps the
// label of its cluster, the others get new labels.
void SplitAtCreases(std::span<const float> positions,
                    std::span<const float> colors,
                    std::span<const float> normals,
                    const CreaseSplitOptions& options,
                    ThreadPool& pool,
                    std::vector<int32_t>* labels);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_INSTANCES_CREASE_SPLIT_H_
