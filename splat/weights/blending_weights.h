// SPDX-License-Identifier: BSD-3-Clause
// The blending weights of one view as a sparse matrix W, pixels x Gaussians:
// W(p, i) = T_i alpha'_i at pixel p (FreeGS eq. 1). While the geometry does not
// change they are constants. Blending features f of the Gaussians onto the
// image, sum_i T_i alpha'_i f_i (FreeGS eq. 4), is then the product W f; see
// blending_products.h.
//
//   FREEGS_ASSIGN_OR_RETURN(
//       const BlendingWeights weights,
//       ComputeBlendingWeights(model, camera, cam_from_world, {}, pool));
//   ImageF image(camera.width, camera.height, channels);
//   FREEGS_RETURN_IF_ERROR(Multiply(weights.matrix(), features, channels, pool,
//                                   {image.data(), image.size()}));

#ifndef FREEGS_SPLAT_WEIGHTS_BLENDING_WEIGHTS_H_
#define FREEGS_SPLAT_WEIGHTS_BLENDING_WEIGHTS_H_

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/parallel.h"
#include "core/pinhole.h"
#include "core/status.h"
#include "splat/render/renderer.h"
#include "splat/scene/gaussian_model.h"
#include "splat/weights/raw_vector.h"

namespace freegs::splat {

// A view of W in compressed rows. The memory belongs to BlendingWeights or to a
// file mapped into memory. Pixel (x, y) is row y * width + x. A row lists its
// Gaussians front to back, each at most once, with weights in (0, 0.99].
struct WeightMatrix {
  int width = 0;             // Pixels.
  int height = 0;            // Pixels.
  size_t num_gaussians = 0;  // Columns: every Gaussian of the model.

  // Row p consists of entries pixel_begin[p] .. pixel_begin[p + 1] - 1 of the
  // two other arrays.
  std::span<const uint32_t> pixel_begin;  // width * height + 1.
  std::span<const uint32_t> gaussians;    // Indices into the model.
  std::span<const float> weights;

  size_t num_pixels() const { return static_cast<size_t>(width) * height; }
  size_t num_weights() const { return weights.size(); }

  // Bytes of the three arrays.
  size_t num_bytes() const {
    return sizeof(uint32_t) * (pixel_begin.size() + gaussians.size()) +
           sizeof(float) * weights.size();
  }
};

// A matrix W that owns its memory.
struct BlendingWeights {
  int width = 0;
  int height = 0;
  size_t num_gaussians = 0;
  RawVector<uint32_t> pixel_begin;
  RawVector<uint32_t> gaussians;
  RawVector<float> weights;

  // Valid until this object or one of its arrays changes.
  WeightMatrix matrix() const {
    return {width, height, num_gaussians, pixel_begin, gaussians, weights};
  }
};

// Computes the weights with which RenderView blends: those of splats with alpha
// of at least 1/255 at pixels whose transmittance is at least 1e-4 (see
// tile_kernels.h). A row sums to 1 - transmittance. For an image of another
// size pass camera.LimitedTo(side) or camera.Resized(width, height). The
// background and the SH degree of `options` have no influence.
//
// Needs up to twice the memory of the result, which takes 8 bytes per weight:
// the tiles are blended first, and put together when all weights are counted.
// The result is the same bytes for any number of threads and any instruction
// set; so it differs from what the renderer blends by rounding, about 1e-6.
// Fails with kInvalidArgument when the camera has no pixels, and with
// kUnusableResult when the view has 2^32 weights or more, or 2^31 pairs of
// splats and tiles; a smaller image has fewer.
StatusOr<BlendingWeights> ComputeBlendingWeights(const GaussianModel& model,
                                                 const Pinhole& camera,
                                                 const Rigid3d& cam_from_world,
                                                 const RenderOptions& options,
                                                 ThreadPool& pool);

// The same in memory that *result has already, for one view after the other.
Status ComputeBlendingWeights(const GaussianModel& model,
                              const Pinhole& camera,
                              const Rigid3d& cam_from_world,
                              const RenderOptions& options,
                              ThreadPool& pool,
                              BlendingWeights* result);

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_WEIGHTS_BLENDING_WEIGHTS_H_
