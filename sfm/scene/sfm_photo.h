// SPDX-License-Identifier: BSD-3-Clause
// The photographs whose cameras are wanted.

#ifndef FREEGS_SFM_SCENE_SFM_PHOTO_H_
#define FREEGS_SFM_SCENE_SFM_PHOTO_H_

#include <string>

namespace freegs::sfm {

// A photo to be posed.
struct SfmPhoto {
  std::string name;      // File, relative to the photo folder.
  std::string file;      // As the user knows it, if that is another name.
  int width = 0;         // Pixels.
  int height = 0;        // Pixels.
  int camera_group = 0;  // Photos of equal number may share one camera.
  double focal_px = 0;   // What EXIF says; 0 when it says nothing.
  double sharpness = 0;  // As ingest measured it; 0 is unknown.
};

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_SCENE_SFM_PHOTO_H_
