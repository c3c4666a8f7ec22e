// SPDX-License-Identifier: BSD-3-Clause

#include "stages/bootstrap/seen_photo.h"

#include <algorithm>
#include <system_error>
#include <utility>

#include "core/io/image_io.h"
#include "core/parallel.h"
#include "splat/render/renderer.h"
#include "stages/scene/exposure_file.h"
#include "stages/scene/training_scene.h"

namespace freegs::stages {

namespace fs = std::filesystem;

StatusOr<ImageU8> ReadSeenPhoto(const fs::path& workspace,
                                const WorkspaceScene& scene,
                                const View& view) {
  FREEGS_ASSIGN_OR_RETURN(
      ImageU8 photo, ReadRgb(workspace / "undistort" / "images" / view.name));
  const fs::path masks = TrainingMaskFolder(workspace);
  const fs::path file = masks / (view.name + ".png");
  std::error_code error;
  if (masks.empty() || !fs::exists(file, error)) return photo;
  FREEGS_ASSIGN_OR_RETURN(const ImageU16 mask, ReadLabels(file));
  const auto has_size = [&](const auto& image) {
    return image.width() == view.camera.width &&
           image.height() == view.camera.height;
  };
  if (!has_size(photo) || !has_size(mask)) {
    return BadInputError(file.string() +
                         ": photo and mask must have the size that the camera "
                         "of undistort/sparse says");
  }
  ThreadPool one_thread(1);
  splat::RenderedView rendered = splat::RenderView(
      scene.model, view.camera, view.cam_from_world, scene.render, one_thread);
  const ImageU8 drawn = ToU8(InExposureOf(
      view.name, scene.exposures, std::move(rendered.color), one_thread));
  for (size_t i = 0; i < mask.num_pixels(); ++i) {
    if (mask.data()[i] != 0) continue;
    std::copy_n(drawn.data() + 3 * i, 3, photo.data() + 3 * i);
  }
  return photo;
}

}  // namespace freegs::stages
