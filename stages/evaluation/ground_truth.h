// SPDX-License-Identifier: BSD-3-Clause
// The truth about a scene: cameras, objects, masks. Files that others wrote.

#ifndef FREEGS_STAGES_EVALUATION_GROUND_TRUTH_H_
#define FREEGS_STAGES_EVALUATION_GROUND_TRUTH_H_

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/pinhole.h"
#include "core/status.h"
#include "semantics/geometry/boxes.h"
#include "sfm/scene/camera.h"
#include "stages/scene/camera_file.h"

namespace freegs::stages {

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
// kBadInput, naming the entry, for missing fields, repeated ids and boxes with
// min > max.
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

#endif  // FREEGS_STAGES_EVALUATION_GROUND_TRUTH_H_
