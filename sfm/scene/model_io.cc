// SPDX-License-Identifier: BSD-3-Clause
// Reads and writes model folders.

#include "sfm/scene/model_io.h"

#include <array>
#include <string>
#include <string_view>

#include "core/io/files.h"
#include "sfm/scene/model_io_binary.h"
#include "sfm/scene/model_io_text.h"

namespace freegs::sfm {
namespace {

namespace fs = std::filesystem;

struct ModelFiles {
  fs::path cameras;
  fs::path images;
  fs::path points3d;
};

ModelFiles FilesOf(const fs::path& folder, ModelFormat format) {
  const std::string suffix = format == ModelFormat::kBinary ? ".bin" : ".txt";
  return {folder / ("cameras" + suffix),
          folder / ("images" + suffix),
          folder / ("points3D" + suffix)};
}

}  // namespace

std::optional<ModelFormat> DetectModelFormat(const fs::path& folder) {
  for (const ModelFormat format : {ModelFormat::kBinary, ModelFormat::kText}) {
    const ModelFiles files = FilesOf(folder, format);
    std::error_code error;
    if (fs::is_regular_file(files.cameras, error) &&
        fs::is_regular_file(files.images, error) &&
        fs::is_regular_file(files.points3d, error)) {
      return format;
    }
  }
  return {};
}

StatusOr<Reconstruction> ReadModelUnchecked(const fs::path& folder) {
  const std::optional<ModelFormat> format = DetectModelFormat(folder);
  if (!format) {
    return BadInputError(folder.string() +
                         ": no COLMAP model here; cameras, images and points3D "
                         "must all be there, as .bin or as .txt");
  }
  const ModelFiles files = FilesOf(folder, *format);
  const bool binary = *format == ModelFormat::kBinary;
  Reconstruction model;

  FREEGS_ASSIGN_OR_RETURN(std::string bytes, ReadFile(files.cameras));
  FREEGS_RETURN_IF_ERROR((binary ? ParseCamerasBinary(bytes, &model.cameras)
                                 : ParseCamerasText(bytes, &model.cameras))
                             .Annotated(files.cameras.string()));
  FREEGS_ASSIGN_OR_RETURN(bytes, ReadFile(files.images));
  FREEGS_RETURN_IF_ERROR((binary ? ParseImagesBinary(bytes, &model.images)
                                 : ParseImagesText(bytes, &model.images))
                             .Annotated(files.images.string()));
  FREEGS_ASSIGN_OR_RETURN(bytes, ReadFile(files.points3d));
  FREEGS_RETURN_IF_ERROR((binary ? ParsePointsBinary(bytes, &model.points3d)
                                 : ParsePointsText(bytes, &model.points3d))
                             .Annotated(files.points3d.string()));
  return model;
}

StatusOr<Reconstruction> ReadModel(const fs::path& folder) {
  FREEGS_ASSIGN_OR_RETURN(Reconstruction model, ReadModelUnchecked(folder));
  FREEGS_RETURN_IF_ERROR(CheckReconstruction(model).Annotated(folder.string()));
  return model;
}

Status WriteModel(const fs::path& folder,
                  const Reconstruction& model,
                  ModelFormat format) {
  FREEGS_RETURN_IF_ERROR(CreateFolders(folder));
  const ModelFiles files = FilesOf(folder, format);
  const bool binary = format == ModelFormat::kBinary;
  FREEGS_RETURN_IF_ERROR(WriteFileAtomic(
      files.cameras,
      binary ? CamerasToBinary(model.cameras) : CamerasToText(model.cameras)));
  FREEGS_RETURN_IF_ERROR(WriteFileAtomic(
      files.images,
      binary ? ImagesToBinary(model.images) : ImagesToText(model.images)));
  return WriteFileAtomic(
      files.points3d,
      binary ? PointsToBinary(model.points3d) : PointsToText(model.points3d));
}

}  // namespace freegs::sfm
