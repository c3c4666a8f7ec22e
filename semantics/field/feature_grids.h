// SPDX-License-Identifier: BSD-3-Clause
// What CLIP sees at each place of each photograph, in as few numbers as the
// scene needs. This is F_pix of FreeGS ("Pixel-level Feature Distillation"),
// before and after it is brought to the resolution of an image. Other than
// there, the features of a place have length 1.

#ifndef FREEGS_SEMANTICS_FIELD_FEATURE_GRIDS_H_
#define FREEGS_SEMANTICS_FIELD_FEATURE_GRIDS_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/cancellation.h"
#include "core/image.h"
#include "core/parallel.h"
#include "core/status.h"
#include "semantics/clip/clip_encoder.h"
#include "semantics/clip/feature_cache.h"
#include "semantics/clip/joint_bilateral_upsampling.h"
#include "semantics/geometry/principal_axes.h"
#include "semantics/geometry/view_loop.h"

namespace freegs::semantics {

struct FeatureGridOptions {
  // The image size in pixels that the network sees. 0 is the model's default.
  int dense_size = 0;

  // D, the numbers per place. With 0, D is as small as it can be to keep the
  // share kept_energy of the variation between the places of the scene, and at
  // most max_dim. FreeGS uses 128 for every scene.
  int dim = 0;
  double kept_energy = 0.95;
  int max_dim = 128;

  Status Check() const;
};

struct FeatureGrids {
  // Lead from CLIP's C numbers to D. The axes go through the origin, so that
  // inner products are kept, except for what the dropped axes held.
  PrincipalAxes axes;

  // For each view, grid x grid x D: the features of the cells in these axes.
  // They had length 1 before axes were dropped. If `upsampled`, the cells are
  // those that the model's own upsampler gave.
  std::vector<ImageF> grids;
  bool upsampled = false;
};

// Each photograph goes through the network once, or not at all if the cache has
// its features. The axes are those of about 16384 cells that are spread evenly
// over all views. A model that brings an upsampler for this dense_size has each
// grid upsampled by it; the axes are still those of the cells before that, and
// photo_of is called a second time. Beside the grids, upsampled_size^2 x C
// numbers of one view are held then.
//
// Errors: those of photo_of, the encoder and the cache; kInvalidArgument for no
// views and for options out of range; kInterrupted when cancelled
// (`cancellation` may be null). Then the cache keeps what was encoded.
StatusOr<FeatureGrids> ComputeFeatureGrids(
    size_t num_views,
    ViewPhoto photo_of,
    ClipEncoder& encoder,
    const FeatureCache& cache,
    const FeatureGridOptions& options,
    ThreadPool& pool,
    const CancellationToken* cancellation,
    ViewsDone done);

// The features of a view at the size of the guide, W x H x D: by joint
// bilateral upsampling, or bilinearly where the model's upsampler has found the
// borders. guide: the photograph, RGB in [0, 1]. The result has the same bytes
// for any number of threads. Errors as JointBilateralUpsample.
StatusOr<ImageF> UpsampleView(const FeatureGrids& grids,
                              size_t view,
                              const ImageF& guide,
                              const JointBilateralOptions& options,
                              ThreadPool& pool);

// Does what UpsampleView does, for some pixels of the guide only: returns
// pixels.size() x D, row-major.
StatusOr<std::vector<float>> UpsampleViewAt(
    const FeatureGrids& grids,
    size_t view,
    const ImageF& guide,
    std::span<const PixelIndex> pixels,
    const JointBilateralOptions& options,
    ThreadPool& pool);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_FIELD_FEATURE_GRIDS_H_
