// SPDX-License-Identifier: BSD-3-Clause
// The truth about a scene: cameras, objects and masks. ReadGroundTruth reads it
// in the layout of the scene maker (docs/scene_maker.md);
// stages/datasets/layout.h also knows those of public data sets.

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
  std::string label;  // "red apple"; several objects may share a label.

  // The box around the whole object, hidden parts included, in the truth's
  // frame. There is none where only masks are known.
  std::optional<semantics::AxisAlignedBox> aabb;
};

// An object file is JSON:
//   {"objects": [{"id": 1, "label": "red apple",
//                 "aabb": {"min": [x, y, z], "max": [x, y, z]}}, ...]}
// Other fields are ignored. Objects are returned by ascending id. The error is
// kBadInput, naming the entry, for missing fields, repeated ids, and boxes with
// min > max.
StatusOr<std::vector<TrueObject>> ReadTrueObjects(
    const std::filesystem::path& path);
StatusOr<std::vector<TrueObject>> ParseTrueObjects(std::string_view json,
                                                   const std::string& source);

// An image file that marks where objects are.
struct MaskFile {
  std::filesystem::path path;

  // The object that is where the image is bright; 0 for an image whose pixel
  // values are object ids.
  int object = 0;
};

// What is known about a scene, whatever its layout on disk.
struct GroundTruth {
  std::filesystem::path folder;
  CameraSet cameras;
  std::vector<TrueObject> objects;  // By ascending id.

  // Photographs and masks of test views, by the view's name.
  std::map<std::string, std::filesystem::path> photos;
  std::map<std::string, std::vector<MaskFile>> masks;

  // The lenses of test views whose masks were drawn on a distorted photograph.
  // The view's own camera has no distortion.
  std::map<std::string, sfm::Camera> lenses;

  // Names of further test views whose cameras the data set does not give. They
  // take the camera that the workspace has found for its photograph of this
  // name; see TakeWorkspaceCameras.
  std::vector<std::string> unposed;

  // True when every object that a test view shows is marked there and no two
  // masks overlap.
  bool complete = false;
};

// Reads a scene folder, or the folder gt in it:
//   gt/cameras.json        a camera file (stages/scene/camera_file.h)
//   gt/objects.json        an object file (optional)
//   gt/instance/VIEW.png   object id per pixel, 0 for background (optional)
//   test/images/VIEW.png   photographs of the test views (optional)
// kBadInput names the file and the fault.
StatusOr<GroundTruth> ReadGroundTruth(const std::filesystem::path& folder);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_EVALUATION_GROUND_TRUTH_H_
