// SPDX-License-Identifier: BSD-3-Clause
// Blending weights as the renderer has them, found out by rendering.

#ifndef FREEGS_TESTS_SPLAT_DENSE_WEIGHTS_H_
#define FREEGS_TESTS_SPLAT_DENSE_WEIGHTS_H_

#include <vector>

#include "core/parallel.h"
#include "core/pinhole.h"
#include "splat/render/renderer.h"
#include "splat/scene/gaussian_model.h"

namespace freegs::splat {

// One-hot vectors, rendered: channel i of pixel p is the weight of Gaussian i
// there. For small models.
inline RenderedView RenderDenseWeights(const GaussianModel& model,
                                       const Pinhole& camera,
                                       const Rigid3d& cam_from_world,
                                       ThreadPool& pool) {
  const size_t count = model.size();
  std::vector<float> one_hot(count * count, 0.0f);
  for (size_t i = 0; i < count; ++i) one_hot[i * count + i] = 1;
  return RenderView(model,
                    camera,
                    cam_from_world,
                    RenderOptions(),
                    pool,
                    {one_hot, static_cast<int>(count)});
}

}  // namespace freegs::splat

#endif  // FREEGS_TESTS_SPLAT_DENSE_WEIGHTS_H_
