// SPDX-License-Identifier: BSD-3-Clause
// From a model and its photographs to patches and their graph.

#ifndef FREEGS_SEMANTICS_PATCHES_SCENE_PATCHES_H_
#define FREEGS_SEMANTICS_PATCHES_SCENE_PATCHES_H_

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "core/cancellation.h"
#include "core/image.h"
#include "core/parallel.h"
#include "core/pinhole.h"
#include "core/status.h"
#include "semantics/patches/region_graph.h"
#include "splat/render/renderer.h"
#include "splat/scene/gaussian_model.h"

namespace freegs::semantics {

struct PatchOptions {
  // Gaussians of less opacity are haze and belong to no patch.
  double min_opacity = 0.1;

  // So do those whose second largest standard deviation is larger than this,
  // in scene radii (see SceneExtent).
  double max_scale = 1;

  // Longest side in pixels of the photographs in which patches are compared.
  int max_side = 400;

  // Photographs that are looked at: at most so many, evenly chosen.
  int max_views = 24;

  // Extent of a patch in these photographs, in pixels.
  double patch_pixels = 8;

  Status Check() const;
};

struct ScenePatches {
  std::vector<int32_t> patch_of_gaussian;  // -1 for none.
  RegionGraph graph;                       // A region for each patch.
};

// What the patches are made from. `photo_of` returns the photograph of a view,
// of any size. semantics: `dim` numbers for each Gaussian, or empty.
struct PatchScene {
  const splat::GaussianModel& model;
  std::span<const View> views;
  const splat::RenderOptions& render;
  std::function<StatusOr<ImageU8>(size_t view)> photo_of;
  std::span<const float> semantics;
  int dim = 0;
  double scene_radius = 1;  // World units.
};

// The same input gives the same result for any number of threads.
// kInvalidArgument for options out of range; kInterrupted when cancelled
// (`cancellation` may be null); errors of photo_of.
StatusOr<ScenePatches> BuildScenePatches(const PatchScene& scene,
                                         const PatchOptions& options,
                                         ThreadPool& pool,
                                         const CancellationToken* cancellation);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_PATCHES_SCENE_PATCHES_H_
