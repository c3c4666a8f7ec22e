// SPDX-License-Identifier: BSD-3-Clause
// From a model and its photographs to patches and their graph.

#ifndef FREEGS_SEMANTICS_PATCHES_SCENE_PATCHES_H_
#define FREEGS_SEMANTICS_PATCHES_SCENE_PATCHES_H_

#include <cstddef>
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

// Longest side in pixels of the photographs in which patches are compared.
inline constexpr int kPatchImageSide = 400;
// At most so many of them are looked at, evenly chosen. Nothing depends on the
// others, so that few views and all of them can give the same patches.
inline constexpr size_t kMaxPatchViews = 24;
// Where the patches are is chance, and with it which regions grow from them. So
// the surfaces are divided in several ways (docs/instances.md).
inline constexpr int kNumDivisions = 4;

// One division of the surfaces into patches.
struct ScenePatches {
  std::vector<int32_t> patch_of_gaussian;  // -1 for none.
  // For each Gaussian: how many pixels of the photographs it covers.
  std::vector<double> seen;
  RegionGraph graph;  // A region for each patch.
};

// What the patches are made from. `photo_of` returns the photograph of
// views[view], of any size. It may be called on several threads at once.
struct PatchScene {
  const splat::GaussianModel& model;
  std::span<const View> views;
  const splat::RenderOptions& render;
  std::function<StatusOr<ImageU8>(size_t view)> photo_of;
  double scene_radius = 1;  // SceneExtent::radius.
};

// Returns kNumDivisions divisions. Patches know no semantics; SetSemantics adds
// them. The same input gives the same result for any number of threads.
// kInterrupted when cancelled (`cancellation` may be null); errors of photo_of.
StatusOr<std::vector<ScenePatches>> BuildScenePatches(
    const PatchScene& scene,
    ThreadPool& pool,
    const CancellationToken* cancellation);

// Gives each region the sum of the unit vectors of its Gaussians, weighted by
// the pixels that they cover, in place of what it had. semantics: `dim` numbers
// for each Gaussian, zero where nothing is known.
void SetSemantics(std::span<const float> semantics,
                  int dim,
                  ScenePatches* patches);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_PATCHES_SCENE_PATCHES_H_
