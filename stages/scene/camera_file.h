// SPDX-License-Identifier: BSD-3-Clause
// A camera file: views by name, as the program reads them for rendering and for
// evaluation.

#ifndef FREEGS_STAGES_SCENE_CAMERA_FILE_H_
#define FREEGS_STAGES_SCENE_CAMERA_FILE_H_

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/pinhole.h"
#include "core/status.h"

namespace freegs::stages {

// Cameras of the photos to reconstruct from, and of further views.
struct CameraSet {
  std::vector<View> train;
  std::vector<View> test;
};

// Reads a camera file, JSON:
//   {"intrinsics": {"w", "h", "fx", "fy", "cx", "cy"},
//    "train": {"frame_0001.jpg": world_to_camera, ...}, "test": {...}}
// with 4x4 (or 3x4) row-major world_to_camera, axes x right, y down, z forward,
// pixel centres at +0.5. "fy", "cx" and "cy" default to fx and the image's
// middle; "train" or "test" may be missing, not both. Views come by ascending
// name. kBadInput, naming `source` and the entry, for missing or non-numeric
// fields, sizes outside 1..65535, matrices that are not a rotation and a
// translation (tolerance 1e-3), and names that lead out of a folder.
StatusOr<CameraSet> ReadCameraSet(const std::filesystem::path& path);
StatusOr<CameraSet> ParseCameraSet(std::string_view json,
                                   const std::string& source);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_SCENE_CAMERA_FILE_H_
