// SPDX-License-Identifier: BSD-3-Clause
// A whole model through a camera: culling, EWA projection, colour, depth order.

#ifndef FREEGS_SPLAT_PROJECTION_PROJECTION_H_
#define FREEGS_SPLAT_PROJECTION_PROJECTION_H_

#include <cstdint>
#include <vector>

#include "core/parallel.h"
#include "core/pinhole.h"
#include "splat/projection/ewa_projection.h"
#include "splat/scene/gaussian_model.h"
#include "splat/projection/projection_simd.h"
#include "splat/projection/render_options.h"
#include "splat/projection/splat.h"

namespace freegs::splat {

template <typename T>
ProjectionCamera<T> MakeProjectionCamera(const Pinhole& camera,
                                         const Rigid3d& cam_from_world,
                                         const RenderOptions& options);

ProjectionTask MakeProjectionTask(const GaussianModel& model,
                                  const Pinhole& camera,
                                  const Rigid3d& cam_from_world,
                                  const RenderOptions& options);

// The visible Gaussians of a view, nearest first.
struct Projection {
  std::vector<Splat> splats;
  std::vector<uint32_t> model_index;  // Gaussian of each splat.

  // The same in the order of the model: Gaussian visible[j] is splat rank[j].
  std::vector<uint32_t> visible;
  std::vector<uint32_t> rank;

  size_t size() const { return splats.size(); }
};

// Projects every Gaussian, drops what cannot touch a pixel, sorts by depth
// (ties by index). Keeps its scratch memory between calls.
class Projector {
 public:
  void Project(const GaussianModel& model,
               const Pinhole& camera,
               const Rigid3d& cam_from_world,
               const RenderOptions& options,
               ThreadPool& pool,
               Projection* projection);

 private:
  std::vector<Splat> by_model_;
  std::vector<uint32_t> visible_;
  std::vector<uint32_t> chunk_counts_;
  std::vector<uint64_t> keys_;
  std::vector<uint64_t> keys_scratch_;
};

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_PROJECTION_PROJECTION_H_
