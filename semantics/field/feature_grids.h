// SPDX-License-Identifier: BSD-3-Clause
// What CLIP sees at each place of each photograph, in as few numbers as the
// scene needs: F_pix of FreeGS ("Pixel-level Feature Distillation") before it
// is brought to the resolution of an image.

#ifndef FREEGS_SEMANTICS_FIELD_FEATURE_GRIDS_H_
#define FREEGS_SEMANTICS_FIELD_FEATURE_GRIDS_H_

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/cancellation.h"
#include "core/function_ref.h"
#include "core/image.h"
#include "core/parallel.h"
#include "core/status.h"
#include "semantics/clip/clip_encoder.h"
#include "semantics/clip/feature_cache.h"
#include "semantics/geometry/principal_axes.h"

namespace freegs::semantics {

struct FeatureGridOptions {
  // Image size in pixels that the network sees; 0 is the model's default.
  int dense_size = 0;

  // Numbers per place, D; 0 takes as many as keep this share of what varies
  // between the scene's places, up to max_dim. FreeGS: 128, whatever the scene.
  int dim = 0;
  double kept_energy = 0.95;
  int max_dim = 128;

  Status Check() const;
};

struct FeatureGrids {
  // From CLIP's C numbers to D, about the origin: inner products of features
  // are kept but for what the dropped axes held.
  PrincipalAxes axes;

  // Per view, grid x grid x D: the coordinates of the cells' features, which
  // were of length 1 before axes were dropped.
  std::vector<ImageF> grids;
};

// The photograph of a view, RGB.
using ViewPhoto = FunctionRef<StatusOr<ImageU8>(size_t view)>;

// Called after each of the views has been encoded.
using ViewsDone = FunctionRef<void(size_t count)>;

// Each photograph goes through the network once, or never if the cache knows
// it. The axes are those of 16384 cells evenly spread over all views. Errors of
// the callback, the encoder and the cache; kInvalidArgument without views or
// for options out of range; kInterrupted when cancelled (`cancellation` may be
// null): what was encoded is in the cache.
StatusOr<FeatureGrids> ComputeFeatureGrids(
    size_t num_views,
    ViewPhoto photo_of,
    ClipEncoder& encoder,
    const FeatureCache& cache,
    const FeatureGridOptions& options,
    ThreadPool& pool,
    const CancellationToken* cancellation,
    ViewsDone done);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_FIELD_FEATURE_GRIDS_H_
