// SPDX-License-Identifier: BSD-3-Clause
// Projects a whole model into a camera: drops the Gaussians that the view does
// not show, computes image position, shape and colour of the others, and sorts
// them by depth.
//
//   Projector projector;
//   Projection projection;
//   projector.Project(model, camera, cam_from_world, {}, pool, &projection);
//   for (const Splat& splat : projection.splats) ...  // Nearest first.

#ifndef FREEGS_SPLAT_PROJECTION_PROJECTION_H_
#define FREEGS_SPLAT_PROJECTION_PROJECTION_H_

#include <cstdint>
#include <vector>

#include "core/parallel.h"
#include "core/pinhole.h"
#include "splat/projection/ewa_projection.h"
#include "splat/projection/projection_simd.h"
#include "splat/projection/render_options.h"
#include "splat/projection/splat.h"
#include "splat/scene/gaussian_model.h"

namespace freegs::splat {

// Exists for T = float and double.
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
  std::vector<uint32_t> model_index;  // The Gaussian of each splat.

  // The same pairs in the order of the model: Gaussian visible[j] (ascending)
  // is splat rank[j].
  std::vector<uint32_t> visible;
  std::vector<uint32_t> rank;

  size_t size() const { return splats.size(); }
};

// Keeps its scratch memory between calls, so that projecting view after view
// allocates nothing.
class Projector {
 public:
  // Overwrites *projection with the Gaussians that can touch a pixel, sorted by
  // depth and, at the same depth, by index. The result is the same for any
  // number of threads.
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
