// SPDX-License-Identifier: BSD-3-Clause
// Projects a whole model into a camera: drops the Gaussians that the view does
// not show, computes image position, shape and colour of the others, and sorts
// them by depth.
//
//   Projector projector;
//   Projection projection;
//   projector.Project(model, camera, cam_from_world, {}, pool, &projection);
//   for (const uint32_t place : projection.by_depth) {  // Nearest first.
//     const Splat& splat = projection.splats[projection.visible[place]];
//   }

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

// The visible Gaussians of a view. Everything but the order of depth is in the
// order of the model, in which neighbours in space lie together in memory.
struct Projection {
  // The splat of each Gaussian of the model. Those of Gaussians that are not
  // visible hold anything.
  std::vector<Splat> splats;
  std::vector<uint32_t> visible;   // The visible Gaussians, ascending.
  std::vector<uint32_t> by_depth;  // Places in `visible`, nearest first.

  // The number of visible Gaussians.
  size_t size() const { return visible.size(); }
  const Splat& SplatAt(size_t place) const { return splats[visible[place]]; }
};

// Keeps its scratch memory between calls, so that projecting view after view
// allocates nothing.
class Projector {
 public:
  // Overwrites *projection with the Gaussians that can touch a pixel. Those of
  // the same depth are in the order of the model. The result is the same for
  // any number of threads.
  void Project(const GaussianModel& model,
               const Pinhole& camera,
               const Rigid3d& cam_from_world,
               const RenderOptions& options,
               ThreadPool& pool,
               Projection* projection);

 private:
  void SortByDepth(ThreadPool& pool, std::vector<uint32_t>* by_depth);

  std::vector<uint32_t> found_;  // What each chunk of the model found visible.
  std::vector<uint32_t> chunk_begin_;
  std::vector<uint64_t> keys_;
  std::vector<uint64_t> keys_scratch_;
  std::vector<uint32_t> buckets_;
};

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_PROJECTION_PROJECTION_H_
