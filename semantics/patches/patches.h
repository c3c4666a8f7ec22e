// SPDX-License-Identifier: BSD-3-Clause
// Cuts the surfaces of a scene into small patches of Gaussians (supervoxels),
// the pieces that instances are put together from.

#ifndef FREEGS_SEMANTICS_PATCHES_PATCHES_H_
#define FREEGS_SEMANTICS_PATCHES_PATCHES_H_

#include <cstdint>
#include <span>
#include <vector>

#include "core/parallel.h"
#include "core/pinhole.h"
#include "core/status.h"

namespace freegs::semantics {

// Points of surfaces, for example the centres of Gaussians. All are N x 3.
struct SurfacePoints {
  std::vector<float> positions;  // Model frame.
  std::vector<float> normals;    // Unit length; their sign means nothing.
  std::vector<float> colors;     // RGB in [0, 1].
};

// Returns for each point the length that `pixels` pixels cover at its place:
// seen from the nearest quarter of the cameras that have the point in their
// image. Points that no camera has in its image get the median of the others.
// 0 everywhere if there are no views or none sees a point. positions: N x 3.
// The cameras' images have the size in which pixels are counted.
std::vector<float> LengthOfPixels(std::span<const float> positions,
                                  std::span<const View> views,
                                  double pixels,
                                  ThreadPool& pool);

// The patch of each point, 0 .. count - 1.
struct Patches {
  std::vector<int32_t> patch_of_point;
  int count = 0;
};

// Begins with the cells of grids, finer ones where `sizes`, the wanted extent
// of a patch at each point, are smaller. Then points move to the patch that is
// nearest in position, colour and normal, and patches to the mean of their
// points, in turn (k-means, as in Papon et al. 2013). Where the patches are is
// chance: each `division`, from 0 on, has grids of its own, which are shifted
// by other parts of a cell. The result does not depend on the number of
// threads. kInvalidArgument for positions that KdTree::Build refuses and for
// sizes that are not positive.
StatusOr<Patches> MakePatches(const SurfacePoints& points,
                              std::span<const float> sizes,
                              int division,
                              ThreadPool& pool);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_PATCHES_PATCHES_H_
