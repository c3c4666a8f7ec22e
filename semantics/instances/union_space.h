// SPDX-License-Identifier: BSD-3-Clause
// The space Gaussians are clustered in: position, colour and, later, semantics
// side by side (FreeGS, "Union-space Clustering").

#ifndef FREEGS_SEMANTICS_INSTANCES_UNION_SPACE_H_
#define FREEGS_SEMANTICS_INSTANCES_UNION_SPACE_H_

#include <span>
#include <vector>

#include "core/status.h"
#include "semantics/geometry/scene_extent.h"

namespace freegs::semantics {

struct UnionSpaceOptions {
  // Factor on positions once they are divided by the scene radius.
  double position_weight = 1;

  // Factor on colours of [0, 1].
  double color_weight = 0.1;

  // Factor on the semantic block once it is normalised. 0 leaves it out: the
  // places that a small CLIP tells apart are as often parts of one thing (the
  // seat and the legs of a stool) as things that touch. See the table in
  // docs/semantic_field.md.
  double semantic_weight = 0;

  Status Check() const;
};

// N x (6 + semantic_dim) points for clustering, row-major: each block
// normalised and weighted.
//
// FreeGS scales every block by its minimum and maximum. Real scenes have
// Gaussians far outside, which would squash everything of interest, so blocks
// are scaled robustly and as a whole (one factor, which keeps their shape):
// positions by the scene extent and clamped to 10 radii, where only stray
// Gaussians are; colours are in [0, 1] by nature and clamped to it; the
// semantic block by its 0.5 and 99.5 % quantiles over all entries, clamped.
//
// positions, colors: N x 3; semantics: N x semantic_dim, or empty with 0.
std::vector<float> BuildUnionSpace(std::span<const float> positions,
                                   std::span<const float> colors,
                                   std::span<const float> semantics,
                                   int semantic_dim,
                                   const SceneExtent& extent,
                                   const UnionSpaceOptions& options);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_INSTANCES_UNION_SPACE_H_
