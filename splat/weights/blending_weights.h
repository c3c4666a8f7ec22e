// SPDX-License-Identifier: BSD-3-Clause
// The blending weights of one view as a sparse matrix W, pixels x Gaussians:
// W(p, i) = T_i alpha'_i at pixel p (FreeGS eq. 1). With the geometry frozen
// they are constants, and what is blended onto the image, sum_i T_i alpha'_i
// f_i (FreeGS eq. 4), is the product W f; see blending_products.h.

#ifndef FREEGS_SPLAT_WEIGHTS_BLENDING_WEIGHTS_H_
#define FREEGS_SPLAT_WEIGHTS_BLENDING_WEIGHTS_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/parallel.h"
#include "core/pinhole.h"
#include "core/status.h"
#include "splat/scene/gaussian_model.h"
#include "splat/render/renderer.h"

namespace freegs::splat {

// W in compressed rows, wherever they lie: in BlendingWeights or in a file
// mapped into memory. Pixel (x, y) is row y * width + x. A row lists its
// Gaussians front to back, each at most once, with weights in (0, 0.99].
struct WeightMatrix {
  int width = 0;             // Pixels.
  int height = 0;            // Pixels.
  size_t num_gaussians = 0;  // Columns: every Gaussian of the model.

  // Row p is entries pixel_begin[p] .. pixel_begin[p + 1] - 1 of the others.
  std::span<const uint32_t> pixel_begin;  // width * height + 1.
  std::span<const uint32_t> gaussians;    // Index into the model.
  std::span<const float> weights;

  size_t num_pixels() const { return static_cast<size_t>(width) * height; }
  size_t num_weights() const { return weights.size(); }

  // Of the three arrays.
  size_t num_bytes() const {
    return sizeof(uint32_t) * (pixel_begin.size() + gaussians.size()) +
           sizeof(float) * weights.size();
  }
};

// The matrix with memory of its own.
struct BlendingWeights {
  int width = 0;
  int height = 0;
  size_t num_gaussians = 0;
  std::vector<uint32_t> pixel_begin;
  std::vector<uint32_t> gaussians;
  std::vector<float> weights;

  // Valid as long as this and its arrays are.
  WeightMatrix matrix() const {
    return {width, height, num_gaussians, pixel_begin, gaussians, weights};
  }
};

// The weights with which RenderView blends, no more and no fewer: alpha at
// least 1/255, pixels whose transmittance is at least 1e-4 (see
// tile_kernels.h). A row sums to 1 - transmittance. For an image of another
// size pass camera.LimitedTo(side) or camera.Resized(width, height): the
// weights are those of rendering at that size. Of `options` the background and
// the SH degree do not matter.
//
// Memory: the result, 8 bytes per weight, and little more: the tiles are
// blended twice, first to count. The same bytes for any number of threads.
// kInvalidArgument for a camera without pixels; kUnusableResult when the view
// has 2^32 weights or more, which a smaller image cures.
StatusOr<BlendingWeights> ComputeBlendingWeights(const GaussianModel& model,
                                                 const Pinhole& camera,
                                                 const Rigid3d& cam_from_world,
                                                 const RenderOptions& options,
                                                 ThreadPool& pool);

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_WEIGHTS_BLENDING_WEIGHTS_H_
