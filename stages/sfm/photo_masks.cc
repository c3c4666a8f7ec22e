// SPDX-License-Identifier: BSD-3-Clause

#include "stages/sfm/photo_masks.h"

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <system_error>

#include "core/cancellation.h"
#include "core/image.h"
#include "core/io/files.h"
#include "core/io/image_io.h"
#include "sfm/scene/mask_undistortion.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;

// A mask of ingest, which must have the size of its photo's camera.
StatusOr<ImageU8> ReadMask(const fs::path& path, const sfm::Camera& camera) {
  FREEGS_ASSIGN_OR_RETURN(const ImageU16 labels, ReadLabels(path));
  if (static_cast<uint64_t>(labels.width()) != camera.width ||
      static_cast<uint64_t>(labels.height()) != camera.height) {
    return BadInputError(path.string() +
                         ": the mask does not have the size of the camera of "
                         "its photo");
  }
  ImageU8 mask(labels.width(), labels.height(), 1);
  std::transform(labels.data(),
                 labels.data() + labels.size(),
                 mask.data(),
                 [](uint16_t v) { return static_cast<uint8_t>(v != 0); });
  return mask;
}

}  // namespace

bool HasMasks(const pipeline::StageContext& context) {
  std::error_code error;
  return fs::is_directory(context.workspace / "ingest" / "masks", error);
}

Status WriteUndistortedMasks(const sfm::Reconstruction& distorted,
                             const sfm::Reconstruction& pinhole,
                             const pipeline::StageContext& context) {
  const auto from = sfm::IndexCameras(distorted);
  const auto to = sfm::IndexCameras(pinhole);
  std::map<std::string, uint32_t> camera_of;
  for (const sfm::PosedImage& image : distorted.images) {
    camera_of[image.name] = image.camera_id;
  }
  for (const sfm::PosedImage& image : pinhole.images) {
    if (IsCancelled(context.cancellation)) {
      return InterruptedError("stopped on request");
    }
    const auto source = camera_of.find(image.name);
    const fs::path name(image.name + ".png");
    const fs::path path = context.workspace / "ingest" / "masks" / name;
    std::error_code error;
    if (source == camera_of.end() || !fs::exists(path, error)) continue;
    const sfm::Camera& camera = distorted.cameras[from.at(source->second)];
    FREEGS_ASSIGN_OR_RETURN(const ImageU8 mask, ReadMask(path, camera));
    const fs::path target = context.output / "masks" / name;
    FREEGS_RETURN_IF_ERROR(CreateFolders(target.parent_path()));
    FREEGS_RETURN_IF_ERROR(
        WriteImage(target,
                   sfm::UndistortMask(
                       mask, camera, pinhole.cameras[to.at(image.camera_id)])));
  }
  return Status();
}

}  // namespace freegs::stages
