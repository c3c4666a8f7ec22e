// SPDX-License-Identifier: BSD-3-Clause
// The blending weights of one pixel, without rendering the others: what a click
// asks for.

#ifndef FREEGS_SPLAT_WEIGHTS_PIXEL_WEIGHTS_H_
#define FREEGS_SPLAT_WEIGHTS_PIXEL_WEIGHTS_H_

#include <cstdint>
#include <vector>

#include "core/parallel.h"
#include "core/pinhole.h"
#include "core/status.h"
#include "splat/scene/gaussian_model.h"
#include "splat/render/renderer.h"

namespace freegs::splat {

struct PixelWeight {
  uint32_t gaussian = 0;  // Index into the model.
  float weight = 0;       // Blending weight T alpha, in (0, 0.99].
  float depth = 0;        // z of the Gaussian's centre in the camera frame.
};

// The row of pixel (x, y), front to back, of what ComputeBlendingWeights gives
// for the whole view: the same Gaussians and the same bits. All Gaussians are
// projected, but nothing is sorted or blended except what covers the pixel.
// kInvalidArgument for a pixel outside the camera's image.
StatusOr<std::vector<PixelWeight>> ComputePixelWeights(
    const GaussianModel& model,
    const Pinhole& camera,
    const Rigid3d& cam_from_world,
    const RenderOptions& options,
    int x,
    int y,
    ThreadPool& pool);

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_WEIGHTS_PIXEL_WEIGHTS_H_
