// SPDX-License-Identifier: BSD-3-Clause
// One photo, as structure from motion and import need it.

#ifndef FREEGS_SFM_SCENE_SFM_PHOTO_H_
#define FREEGS_SFM_SCENE_SFM_PHOTO_H_

#include <algorithm>
#include <optional>
#include <string>

#include "sfm/scene/camera.h"

namespace freegs::sfm {

// A photo whose camera pose is wanted.
struct SfmPhoto {
  std::string name;      // The file, relative to the photo folder.
  std::string file;      // The name that the user knows, if it differs.
  int width = 0;         // Pixels.
  int height = 0;        // Pixels.
  int camera_group = 0;  // Photos of equal number may share one camera.
  double focal_px = 0;   // Focal length by EXIF, in pixels; 0 is unknown.
  double sharpness = 0;  // As ingest measured it; 0 is unknown.
  int orientation = 1;   // By EXIF, before ingest turned it upright: 1 to 8.

  // The camera, where it is known already. Photos that share one in COLMAP's
  // database must have the same.
  std::optional<Camera> camera = {};
};

// COLMAP's guess where the focal length is unknown, in pixels.
inline double GuessedFocal(const SfmPhoto& photo) {
  return 1.2 * std::max(photo.width, photo.height);
}

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_SCENE_SFM_PHOTO_H_
