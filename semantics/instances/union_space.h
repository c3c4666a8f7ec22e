// SPDX-License-Identifier: BSD-3-Clause
// The space in which Gaussians are clustered: position, colour and semantics
// side by side (FreeGS, "Union-space Clustering").

#ifndef FREEGS_SEMANTICS_INSTANCES_UNION_SPACE_H_
#define FREEGS_SEMANTICS_INSTANCES_UNION_SPACE_H_

#include <span>
#include <vector>

#include "core/status.h"
#include "semantics/geometry/scene_extent.h"

namespace freegs::semantics {

struct UnionSpaceOptions {
  // Factor on positions, which are divided by the scene radius first.
  double position_weight = 1;

  // Factor on colours, which lie in [0, 1].
  double color_weight = 0.1;

  // Factor on the semantic block, which is scaled to [0, 1] first. The default
  // 0 leaves it out: a small CLIP as often tells apart the parts of one thing
  // (the seat and the legs of a stool) as it tells apart things that touch.
  // docs/semantic_field.md has the measurements.
  double semantic_weight = 0;

  // Whether semantics change what is found. Otherwise clustering again finds
  // the same.
  bool with_semantics() const { return semantic_weight > 0; }

  Status Check() const;
};

// Returns points for clustering, N x (6 + semantic_dim), row-major. Each block
// is scaled as a whole, so that it keeps its shape, and then weighted:
// - positions by the scene extent, clamped to 10 radii;
// - colours are in [0, 1] already and are clamped to it;
// - semantics so that the 0.5 % and 99.5 % quantiles of all entries become 0
//   and 1, clamped.
// The paper of FreeGS only says that each block is normalised. Its released
// code scales each coordinate of positions and of semantics on its own, for
// most scenes by its minimum and maximum, and does not scale colours. Real
// scenes have a few Gaussians far outside, which would squash everything of
// interest into a point.
//
// positions, colors: N x 3. semantics: N x semantic_dim, or empty if
// semantic_dim is 0.
std::vector<float> BuildUnionSpace(std::span<const float> positions,
                                   std::span<const float> colors,
                                   std::span<const float> semantics,
                                   int semantic_dim,
                                   const SceneExtent& extent,
                                   const UnionSpaceOptions& options);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_INSTANCES_UNION_SPACE_H_
