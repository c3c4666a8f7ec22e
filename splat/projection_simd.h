// SPDX-License-Identifier: BSD-3-Clause
// The inner loops of projection.h, SIMD over Gaussians; compiled for several
// instruction sets by Highway and chosen at run time.

#ifndef FREEGS_SPLAT_PROJECTION_SIMD_H_
#define FREEGS_SPLAT_PROJECTION_SIMD_H_

#include <cstddef>
#include <cstdint>

#include "splat/ewa_projection.h"
#include "splat/gaussian_model.h"
#include "splat/tile_kernels.h"

namespace freegs::splat {

// A model and the view it is projected into.
struct ProjectionTask {
  const GaussianModel* model = nullptr;
  ProjectionCamera<float> camera;
  int width = 0, height = 0;  // Pixels.
  int sh_degree = 0;          // Evaluated; at most the model's.
};

// Projects Gaussians [begin, end): writes the splat of each that can touch a
// pixel to splats[its index] and lists them, ascending, in `visible`. Returns
// their number.
size_t ProjectRange(const ProjectionTask& task,
                    size_t begin,
                    size_t end,
                    Splat* splats,
                    uint32_t* visible);

// What the derivatives start from. Entry j is Gaussian visible[j] of the model
// and splat number rank[j].
struct ProjectionBackwardTask {
  ProjectionTask forward;
  const uint32_t* visible = nullptr;
  const uint32_t* rank = nullptr;
  const Splat* splats = nullptr;   // By rank.
  const float* moments = nullptr;  // By rank, moment_stride floats each.
  int moment_stride = kMomentStride;
  int depth_extra = -1;  // See SplatMoments.
  GaussianModel* gradients = nullptr;
  float* mean2d_gradients = nullptr;  // By rank, 2 floats each; may be null.
};

// Writes the gradients of entries [begin, end).
void BackwardProjectionRange(const ProjectionBackwardTask& task,
                             size_t begin,
                             size_t end);

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_PROJECTION_SIMD_H_
