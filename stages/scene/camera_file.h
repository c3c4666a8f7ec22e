// SPDX-License-Identifier: BSD-3-Clause
// Reads camera files. `render --cameras`, `query --cameras` and the truth of
// `eval` use them.

#ifndef FREEGS_STAGES_SCENE_CAMERA_FILE_H_
#define FREEGS_STAGES_SCENE_CAMERA_FILE_H_

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/pinhole.h"
#include "core/status.h"

namespace freegs::stages {

// The views of a camera file, in the file's world frame, sorted by name
// (NaturalLess). "train" are the photos that a scene is reconstructed from;
// "test" are further views.
struct CameraSet {
  std::vector<View> train;
  std::vector<View> test;
};

// A camera file is JSON:
//   {"intrinsics": {"w", "h", "fx", "fy", "cx", "cy"},
//    "train": {"frame_0001.jpg": cam_from_world, ...}, "test": {...}}
// Intrinsics are in pixels, and all views share them. "fy" defaults to fx, and
// "cx" and "cy" to the middle of the image. cam_from_world is a 4x4 or 3x4
// matrix, row by row; the camera looks along +z, x points right and y down. One
// of "train" and "test" may be missing. A transforms.json will do, too
// (sfm/import/transforms_json.h): each frame needs "w" and "h" and may have no
// distortion. Frames that it names for evaluation are "test".
//
// The error is kBadInput for missing or non-numeric fields, sizes outside
// 1..65535, matrices that are not a rotation and a translation (tolerance
// 1e-3), and names that lead out of their folder. Its message names `source`,
// which is the file in ReadCameraSet, and the entry.
StatusOr<CameraSet> ReadCameraSet(const std::filesystem::path& path);
StatusOr<CameraSet> ParseCameraSet(std::string_view json,
                                   const std::string& source);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_SCENE_CAMERA_FILE_H_
