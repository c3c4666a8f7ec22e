// SPDX-License-Identifier: BSD-3-Clause
// Moves the mask of a photo to the photo without lens distortion.

#ifndef FREEGS_SFM_SCENE_MASK_UNDISTORTION_H_
#define FREEGS_SFM_SCENE_MASK_UNDISTORTION_H_

#include "core/image.h"
#include "sfm/scene/camera.h"

namespace freegs::sfm {

// The mask as the pinhole camera `pinhole`, which stands where `camera` stood,
// would have taken it: one channel of 0 (ignore) and 255 (use). `mask` is one
// channel of the size of `camera`; 0 is ignore, all else is use. Pixels that
// `camera` did not see are ignored. The nearest pixel of the mask decides. Both
// cameras must pass Check(), and pinhole.IsUndistorted() must be true.
ImageU8 UndistortMask(const ImageU8& mask,
                      const Camera& camera,
                      const Camera& pinhole);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_SCENE_MASK_UNDISTORTION_H_
