// SPDX-License-Identifier: BSD-3-Clause
// The blending weights of one pixel, computed without rendering the other
// pixels. A click on an image asks for them.

#ifndef FREEGS_SPLAT_WEIGHTS_PIXEL_WEIGHTS_H_
#define FREEGS_SPLAT_WEIGHTS_PIXEL_WEIGHTS_H_

#include <cstdint>
#include <vector>

#include "core/parallel.h"
#include "core/pinhole.h"
#include "core/status.h"
#include "splat/render/renderer.h"
#include "splat/scene/gaussian_model.h"

namespace freegs::splat {

struct PixelWeight {
  uint32_t gaussian = 0;  // Index into the model.
  float weight = 0;       // Blending weight T alpha, in (0, 0.99].
  float depth = 0;        // z of the Gaussian's centre in the camera frame.
};

// Returns the row of pixel (x, y), front to back. It holds the same Gaussians
// and the same bits as the row that ComputeBlendingWeights computes for the
// whole view. All Gaussians are projected, but only those that cover the pixel
// are sorted and blended. Fails with kInvalidArgument when the pixel lies
// outside the camera's image.
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
