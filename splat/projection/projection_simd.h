// SPDX-License-Identifier: BSD-3-Clause
// The inner loops of projection.h, SIMD over Gaussians; compiled for several
// instruction sets by Highway and chosen at run time.

#ifndef FREEGS_SPLAT_PROJECTION_PROJECTION_SIMD_H_
#define FREEGS_SPLAT_PROJECTION_PROJECTION_SIMD_H_

#include <cstddef>
#include <cstdint>

#include "splat/projection/ewa_projection.h"
#include "splat/scene/gaussian_model.h"
#include "splat/projection/splat.h"

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

// What the derivatives of a splat start from, in one cache line: in the order
// of the model each is somewhere else in memory.
struct alignas(64) SplatSums {
  // dL/dsplat as sums over its pixels (see tile_kernels.h); dL/dcolor is 0
  // where the colour was cut at 0.
  float moments[kMomentStride];
  float log2_opacity;
  float depth_gradient;  // dL/ddepth, 0 without such a channel.
};

// What the derivatives start from and where they go. Entry j < count is
// Gaussian visible[j] of the model and splat number rank[j].
struct ProjectionBackwardTask {
  ProjectionTask forward;
  size_t count = 0;
  const uint32_t* visible = nullptr;  // Ascending.
  const uint32_t* rank = nullptr;
  const SplatSums* sums = nullptr;  // By rank.
  // The gradient of entry j goes to row rows[j] (ascending) of *gradients, of
  // the model's SH degree: `visible` itself for a container of the model's
  // shapes, or 0, 1, ... for a compact one.
  GaussianGradients* gradients = nullptr;
  const uint32_t* rows = nullptr;
  float* mean2d_gradients = nullptr;  // By rank, 2 floats each, pixels.
};

// Overwrites the rows of the entries; others are left alone.
void BackwardProjection(const ProjectionBackwardTask& task);

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_PROJECTION_PROJECTION_SIMD_H_
