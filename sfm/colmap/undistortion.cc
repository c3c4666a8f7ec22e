// SPDX-License-Identifier: BSD-3-Clause
// Removes lens distortion with COLMAP's image_undistorter.

#include "sfm/colmap/undistortion.h"

#include <algorithm>
#include <cmath>
#include <system_error>
#include <utility>

#include "core/io/files.h"
#include "core/io/image_io.h"
#include "sfm/colmap/colmap_output.h"
#include "sfm/colmap/colmap_program.h"
#include "sfm/colmap/colmap_steps.h"
#include "sfm/scene/model_io.h"

namespace freegs::sfm {
namespace {

namespace fs = std::filesystem;

bool HasDistortion(const Reconstruction& model) {
  return !std::all_of(
      model.cameras.begin(), model.cameras.end(), [](const Camera& camera) {
        return camera.IsUndistorted();
      });
}

Status CheckPhotos(const Reconstruction& model, const fs::path& folder) {
  std::string missing;
  int count = 0;
  for (const PosedImage& image : model.images) {
    std::error_code error;
    if (fs::is_regular_file(folder / image.name, error)) continue;
    if (++count <= 5) missing += (count > 1 ? ", '" : "'") + image.name + "'";
  }
  if (count == 0) return {};
  return BadInputError(folder.string() + ": " + std::to_string(count) +
                       " photos have a pose but no file: " + missing +
                       (count > 5 ? ", ..." : ""));
}

// A camera of a perspective model without distortion, as PINHOLE, with its
// longest side at most max_side pixels (0: any).
Camera AsPinhole(const Camera& camera, int max_side) {
  Camera pinhole = camera;
  pinhole.model = CameraModel::kPinhole;
  pinhole.params = {camera.FocalX(),
                    camera.FocalY(),
                    camera.PrincipalX(),
                    camera.PrincipalY()};
  const double side =
      static_cast<double>(std::max(camera.width, camera.height));
  if (max_side <= 0 || side <= max_side) return pinhole;
  const auto scaled = [&](uint64_t length) {
    return static_cast<uint64_t>(
        std::max(1.0, std::round(length * max_side / side)));
  };
  return pinhole.Resized(scaled(camera.width), scaled(camera.height));
}

// Copies the file and does not link it: whoever edits one of the two files
// leaves the other alone.
Status CopyPhoto(const fs::path& from, const fs::path& to) {
  std::error_code error;
  fs::copy_file(from, to, error);
  if (!error) return {};
  return InternalError(to.string() + ": cannot be written: " + error.message());
}

Status ResizePhoto(const fs::path& from,
                   const fs::path& to,
                   const Camera& camera) {
  FREEGS_ASSIGN_OR_RETURN(const ImageU8 photo, ReadRgb(from));
  return WriteImage(to,
                    Resize(photo,
                           static_cast<int>(camera.width),
                           static_cast<int>(camera.height)));
}

// Photos that have no distortion to be removed.
StatusOr<UndistortionResult> KeepPhotos(const Reconstruction& model,
                                        const UndistortionInput& input) {
  UndistortionResult result;
  result.model = model;
  for (Camera& camera : result.model.cameras) {
    camera = AsPinhole(camera, input.max_image_size);
  }
  const auto index = IndexCameras(model);
  for (PosedImage& image : result.model.images) {
    if (IsCancelled(input.cancellation)) {
      return InterruptedError("stopped on request");
    }
    const Camera& old_camera = model.cameras[index.at(image.camera_id)];
    const Camera& camera = result.model.cameras[index.at(image.camera_id)];
    const fs::path from = input.photo_folder / image.name;
    const fs::path to = input.output / "images" / image.name;
    FREEGS_RETURN_IF_ERROR(CreateFolders(to.parent_path()));
    if (camera.width == old_camera.width &&
        camera.height == old_camera.height) {
      FREEGS_RETURN_IF_ERROR(CopyPhoto(from, to));
      continue;
    }
    result.resampled = true;
    FREEGS_RETURN_IF_ERROR(ResizePhoto(from, to, camera));
    const Eigen::Vector2d scale(
        static_cast<double>(camera.width) / old_camera.width,
        static_cast<double>(camera.height) / old_camera.height);
    for (Point2D& point : image.points2d) point.xy.array() *= scale.array();
  }
  FREEGS_RETURN_IF_ERROR(WriteModel(input.output / "sparse", result.model));
  return result;
}

// Takes COLMAP's sparse model and drops what else it leaves in `folder`.
StatusOr<Reconstruction> ReadUndistorted(const fs::path& folder,
                                         const Reconstruction& original) {
  fs::path sparse = folder / "sparse";
  if (!DetectModelFormat(sparse)) sparse = sparse / "0";
  FREEGS_ASSIGN_OR_RETURN(Reconstruction model, ReadModel(sparse));
  for (const Camera& camera : model.cameras) {
    if (camera.model != CameraModel::kPinhole) {
      return UnusableResultError(
          sparse.string() + ": camera " + std::to_string(camera.id) + " is " +
          std::string(GetCameraModel(camera.model).name) +
          " after undistortion instead of PINHOLE");
    }
  }
  if (model.images.size() != original.images.size()) {
    return UnusableResultError(
        "COLMAP undistorted " + std::to_string(model.images.size()) + " of " +
        std::to_string(original.images.size()) + " photos");
  }
  FREEGS_RETURN_IF_ERROR(CheckPhotos(model, folder / "images"));
  return model;
}

Status RunUndistorter(const Reconstruction& model,
                      const UndistortionInput& input,
                      const fs::path& input_model,
                      const fs::path& folder) {
  const std::string command = "image_undistorter";
  FREEGS_ASSIGN_OR_RETURN(
      ColmapProgram colmap,
      ColmapProgram::Find(input.colmap, input.cancellation));
  FREEGS_ASSIGN_OR_RETURN(const std::set<std::string> options,
                          colmap.Options(command, input.cancellation));
  ChildCommand child = colmap.Command(command);
  child.log_file = input.output / "logs" / (command + ".log");
  child.time_limit_s = TimeLimit(model.images.size());
  ColmapArguments arguments(std::move(child), options);
  arguments.Require("image_path", input.photo_folder.string());
  arguments.Require("input_path", input_model.string());
  arguments.Require("output_path", folder.string());
  arguments.Require("output_type", "COLMAP");
  if (input.max_image_size > 0) {
    arguments.Require("max_image_size", std::to_string(input.max_image_size));
  }
  FREEGS_ASSIGN_OR_RETURN(const ChildCommand run, arguments.Finish());
  const double total = static_cast<double>(model.images.size());
  FREEGS_ASSIGN_OR_RETURN(
      const ChildResult result,
      RunChild(
          run,
          [&](std::string_view line) {
            const auto progress = ParseColmapLine(line);
            if (!progress || !input.progress ||
                progress->kind != ColmapProgress::Kind::kPhotoUndistorted) {
              return;
            }
            input.progress({"undistorting",
                            static_cast<double>(progress->done),
                            total,
                            ""});
          },
          input.cancellation));
  return CheckEnded(input.colmap, command, run.log_file, result);
}

}  // namespace

StatusOr<UndistortionResult> Undistort(const Reconstruction& model,
                                       const UndistortionInput& input) {
  FREEGS_RETURN_IF_ERROR(CheckReconstruction(model));
  FREEGS_RETURN_IF_ERROR(CheckPhotos(model, input.photo_folder));
  std::error_code error;
  fs::remove_all(input.output / "images", error);
  fs::remove_all(input.output / "sparse", error);
  FREEGS_RETURN_IF_ERROR(CreateFolders(input.output / "images"));

  if (!HasDistortion(model)) return KeepPhotos(model, input);

  UndistortionResult result;
  result.resampled = true;
  const fs::path scratch = input.output / "undistorter";
  fs::remove_all(scratch, error);
  FREEGS_RETURN_IF_ERROR(CreateFolders(input.output / "logs"));
  FREEGS_RETURN_IF_ERROR(WriteModel(scratch / "input", model));
  FREEGS_RETURN_IF_ERROR(CreateFolders(scratch / "output"));
  FREEGS_RETURN_IF_ERROR(
      RunUndistorter(model, input, scratch / "input", scratch / "output"));
  StatusOr<Reconstruction> undistorted =
      ReadUndistorted(scratch / "output", model);
  if (undistorted.status().code() == StatusCode::kBadInput) {
    return InternalError(
        "what COLMAP wrote is incomplete (is the disk full?): " +
        undistorted.status().message());
  }
  FREEGS_ASSIGN_OR_RETURN(result.model, std::move(undistorted));
  fs::remove_all(input.output / "images", error);
  fs::rename(scratch / "output" / "images", input.output / "images", error);
  if (error) {
    return InternalError(input.output.string() +
                         "/images: cannot be written: " + error.message());
  }
  FREEGS_RETURN_IF_ERROR(WriteModel(input.output / "sparse", result.model));
  fs::remove_all(scratch, error);
  return result;
}

}  // namespace freegs::sfm
