// SPDX-License-Identifier: BSD-3-Clause
// The scene as the page's 3D view wants it. web/src/scene_data.ts is the other
// side of this.

#ifndef FREEGS_STAGES_VIEWER_VIEWER_SCENE_H_
#define FREEGS_STAGES_VIEWER_VIEWER_SCENE_H_

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/cancellation.h"
#include "core/status.h"

namespace freegs::stages {

struct ViewerSceneOptions {
  // Gaussians come in parts of at most so many, the most visible ones first, so
  // that a large scene is there soon and in outline. The first part is a third
  // of this: it is what slow machines draw while the camera moves.
  int part_size = 100'000;

  // The splats of all parts together become no larger than this, if leaving
  // out what colour depends on the direction is enough for that.
  std::optional<int64_t> max_bytes = std::nullopt;

  // Pictures of photos, relative to the page, by the photos' names.
  std::map<std::string, std::string> pictures = {};

  // Looked at for each part.
  const CancellationToken* cancellation = nullptr;

  // kInvalidArgument when an option is out of range.
  Status Check() const;
};

struct ViewerScene {
  struct Part {
    std::string splats;  // .spz in the frame of the description, not turned.
    // For each of its Gaussians two little-endian uint16: the instance's id, 0
    // for none; and the rank of its part in the hierarchy, 65535 for none.
    std::string labels;
  };

  // {"format": "freegs-viewer-scene", "version": 1, "title", "origin", "unit",
  //  "up", "focus", "radius", "background", "antialiased", "num_gaussians",
  //  "sh_degree",
  //  "photos": [{"name", "holdout", "width", "height", "fx", "fy", "cx", "cy",
  //              "rotation": [w, x, y, z], "translation", "image"}],
  //  "objects": [{"id", "words", "score", "background", "num_gaussians",
  //               "color", "obb": {"center", "size", "rotation"}}],
  //  "levels": {ID: {"wider": [[begin, end], ...], "narrower": ...}},
  //  "parts": [{"num_gaussians"}]}
  // All is in the frame in which stages compute: a position in the world is
  // unit * position + origin. Rotations and translations of photos are camera
  // from scene; the rows of a box's rotation are rows of the matrix.
  nlohmann::json description;
  std::vector<Part> parts;
};

// Reads undistort/, reconstruct/ and, if it exists, bootstrap/ of a workspace.
// Without bootstrap/ there are no objects; without its hierarchy, or where that
// has more than 65535 parts, no levels. Errors are those of ReadWorkspaceScene
// and ReadInstances, and kInterrupted.
StatusOr<ViewerScene> MakeViewerScene(const std::filesystem::path& workspace,
                                      const ViewerSceneOptions& options);

// A script that sets globalThis.freegsScene, for a page that is opened from the
// file system and cannot fetch files. Binary data are in base64.
std::string ViewerSceneScript(const ViewerScene& scene);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_VIEWER_VIEWER_SCENE_H_
