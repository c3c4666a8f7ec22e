// SPDX-License-Identifier: BSD-3-Clause
// The inner loops of projection.h, with one Gaussian per SIMD lane. Highway
// compiles them for several instruction sets and chooses one at run time.

#ifndef FREEGS_SPLAT_PROJECTION_PROJECTION_SIMD_H_
#define FREEGS_SPLAT_PROJECTION_PROJECTION_SIMD_H_

#include <cstddef>
#include <cstdint>

#include "splat/projection/ewa_projection.h"
#include "splat/projection/splat.h"
#include "splat/scene/gaussian_model.h"

namespace freegs::splat {

// A model and the view it is projected into.
struct ProjectionTask {
  const GaussianModel* model = nullptr;
  ProjectionCamera<float> camera;
  int width = 0, height = 0;  // Pixels.
  int sh_degree = 0;          // Degree to evaluate; at most the model's.
};

// Projects Gaussians [begin, end). The splat of a Gaussian that can touch a
// pixel is written to splats[its index], and its index to the next place of
// `visible`, ascending. Returns how many there are. The splats of the other
// Gaussians in the range, and the rest of the end - begin places of `visible`,
// may be overwritten with anything.
size_t ProjectRange(const ProjectionTask& task,
                    size_t begin,
                    size_t end,
                    Splat* splats,
                    uint32_t* visible);

// The inputs of the derivative of one splat, a multiple of 16 bytes.
struct SplatSums {
  // dL/d(splat) as sums over its pixels, see kMomentStride in splat.h.
  // dL/dcolor is 0 where a negative colour was raised to 0.
  float moments[kMomentStride];
  float depth_gradient;  // dL/ddepth, 0 without such a channel.
  float unused[2];
};

// The inputs and outputs of BackwardProjection. Entry j < count is Gaussian
// visible[j] of the model.
struct ProjectionBackwardTask {
  ProjectionTask forward;
  size_t count = 0;
  const uint32_t* visible = nullptr;  // Ascending.
  const SplatSums* sums = nullptr;    // By entry.
  // The gradient of entry j goes to row rows[j] (ascending) of *gradients,
  // which has the model's SH degree. rows is `visible` when *gradients has as
  // many rows as the model, and 0, 1, ... when it has one row per entry.
  GaussianGradients* gradients = nullptr;
  const uint32_t* rows = nullptr;
  // dL/d(mean in pixels) by entry, 2 floats each.
  float* mean2d_gradients = nullptr;
};

// Overwrites the rows of the entries and leaves all other rows alone.
void BackwardProjection(const ProjectionBackwardTask& task);

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_PROJECTION_PROJECTION_SIMD_H_
