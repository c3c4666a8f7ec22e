// SPDX-License-Identifier: BSD-3-Clause
// Views of a reconstruction.

#include "sfm/scene/views.h"

#include <algorithm>
#include <string>

#include "core/text.h"

namespace freegs::sfm {

Pinhole PinholeOf(const Camera& camera) {
  return {static_cast<int>(camera.width),
          static_cast<int>(camera.height),
          camera.FocalX(),
          camera.FocalY(),
          camera.PrincipalX(),
          camera.PrincipalY()};
}

StatusOr<std::vector<View>> MakeViews(const Reconstruction& model) {
  FREEGS_RETURN_IF_ERROR(CheckReconstruction(model));
  const auto camera_index = IndexCameras(model);
  std::vector<View> views;
  views.reserve(model.images.size());
  for (const PosedImage& image : model.images) {
    const Camera& camera = model.cameras[camera_index.at(image.camera_id)];
    if (!camera.IsUndistorted()) {
      return BadInputError(
          "camera " + std::to_string(camera.id) + " of '" + image.name +
          "' has lens distortion (" +
          std::string(GetCameraModel(camera.model).name) +
          "); the undistort stage makes pinhole images: run with --from "
          "undistort");
    }
    View view;
    view.name = image.name;
    view.camera = PinholeOf(camera);
    view.cam_from_world = image.cam_from_world;
    views.push_back(std::move(view));
  }
  std::ranges::sort(views, NaturalLess, &View::name);
  return views;
}

}  // namespace freegs::sfm
