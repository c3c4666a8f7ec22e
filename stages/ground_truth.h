// SPDX-License-Identifier: BSD-3-Clause
// The truth about a scene: cameras, objects, masks. Files that others wrote.

#ifndef FREEGS_STAGES_GROUND_TRUTH_H_
#define FREEGS_STAGES_GROUND_TRUTH_H_

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/pinhole.h"
#include "core/status.h"
#include "semantics/boxes.h"
#include "sfm/camera.h"

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

struct TrueObject {
  int id = 0;         // 1..65535.
  std::string label;  // "red apple"; several objects may share it.

  // Of the whole object, in the truth's frame; nothing where only masks are
  // known.
  std::optional<semantics::AxisAlignedBox> aabb;
  std::optional<semantics::OrientedBox> obb;
};

// Reads an object file, JSON: {"objects": [{"id", "label", "aabb": {"min",
// "max"}, "obb": {"center", "size", "rotation"}}, ...]}, "obb" optional,
// columns of the rotation the box's axes. Objects come by ascending id.
// kBadInput as above, also for repeated ids and boxes with min > max.
StatusOr<std::vector<TrueObject>> ReadTrueObjects(
    const std::filesystem::path& path);
StatusOr<std::vector<TrueObject>> ParseTrueObjects(std::string_view json,
                                                   const std::string& source);

// An image file that marks objects.
struct MaskFile {
  std::filesystem::path path;

  // The object that the file marks where it is bright; 0 for a file whose
  // values are object ids.
  int object = 0;
};

// What is known about a scene. Whatever its layout on disk: see
// datasets/layout.h.
struct GroundTruth {
  std::filesystem::path folder;
  CameraSet cameras;
  std::vector<TrueObject> objects;  // By ascending id.

  // Of test views, by their names.
  std::map<std::string, std::filesystem::path> photos;
  std::map<std::string, std::vector<MaskFile>> masks;

  // The lens of masks that were drawn on a distorted photograph; the view's
  // camera has no distortion.
  std::map<std::string, sfm::Camera> lenses;

  // Names of further test views, without a camera here: what the workspace
  // found for its photograph of that name must do.
  std::vector<std::string> unposed;

  // Every object that a test view shows is marked there, and no two overlap.
  bool complete = false;
};

// Reads a scene folder, or the gt folder in it:
//   gt/cameras.json, gt/objects.json (optional)
//   gt/instance/VIEW.png   object id per pixel, 0 = background (optional)
//   test/images/VIEW.png   photographs of the test views (optional)
StatusOr<GroundTruth> ReadGroundTruth(const std::filesystem::path& folder);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_GROUND_TRUTH_H_
