// SPDX-License-Identifier: BSD-3-Clause

#include "stages/scene/camera_file.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include <Eigen/Geometry>
#include <nlohmann/json.hpp>

#include "core/decompositions.h"
#include "core/io/files.h"
#include "core/io/json_fields.h"
#include "core/number_text.h"
#include "core/text.h"
#include "sfm/import/transforms_json.h"
#include "sfm/scene/views.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr uint64_t kMaxCameraFileBytes = uint64_t{1} << 28;

// Focal lengths and principal points beyond these, in longest sides of the
// picture, are mistakes, such as intrinsics that count in pictures instead of
// pixels. So are positions that far away.
constexpr double kLeastFocal = 0.01;
constexpr double kMostFocal = 1e4;
constexpr double kMostOffset = 100;
constexpr double kMaxTranslation = 1e12;

StatusOr<Pinhole> ReadIntrinsics(const json* value, const std::string& source) {
  if (value == nullptr || !value->is_object()) {
    return BadInputError(source + ": \"intrinsics\" is missing");
  }
  const auto where = [&source](const char* key) {
    return source + ": intrinsics." + key;
  };
  Pinhole camera;
  FREEGS_ASSIGN_OR_RETURN(
      camera.width, ReadInteger(FindField(*value, "w"), 1, 65535, where("w")));
  FREEGS_ASSIGN_OR_RETURN(
      camera.height, ReadInteger(FindField(*value, "h"), 1, 65535, where("h")));
  FREEGS_ASSIGN_OR_RETURN(camera.fx,
                          ReadNumber(FindField(*value, "fx"), where("fx")));
  camera.fy = camera.fx;
  camera.cx = 0.5 * camera.width;
  camera.cy = 0.5 * camera.height;
  for (const auto& [key, target] : {std::pair{"fy", &camera.fy},
                                    std::pair{"cx", &camera.cx},
                                    std::pair{"cy", &camera.cy}}) {
    const json* field = FindField(*value, key);
    if (field == nullptr) continue;
    FREEGS_ASSIGN_OR_RETURN(*target, ReadNumber(field, where(key)));
  }
  const double side = std::max(camera.width, camera.height);
  for (const auto& [key, focal] :
       {std::pair{"fx", camera.fx}, std::pair{"fy", camera.fy}}) {
    if (focal >= kLeastFocal * side && focal <= kMostFocal * side) continue;
    return BadInputError(where(key) + ": " + FormatSignificant(focal, 6) +
                         " pixels is no focal length of such a picture");
  }
  for (const auto& [key, centre] :
       {std::pair{"cx", camera.cx}, std::pair{"cy", camera.cy}}) {
    if (std::abs(centre) <= kMostOffset * side) continue;
    return BadInputError(where(key) + ": " + FormatSignificant(centre, 6) +
                         " pixels is far outside of the picture");
  }
  return camera;
}

StatusOr<std::vector<View>> ReadViews(const json& poses,
                                      const Pinhole& camera,
                                      const std::string& where) {
  if (!poses.is_object()) {
    return BadInputError(where + ": must be an object of named matrices");
  }
  std::vector<View> views;
  for (const auto& [name, value] : poses.items()) {
    const std::string entry = where + "[\"" + name + "\"]";
    if (!IsNameBelowFolder(name)) {
      return BadInputError(entry + ": not the name of a photo");
    }
    const int rows = value.is_array() && value.size() == 3 ? 3 : 4;
    FREEGS_ASSIGN_OR_RETURN(const Eigen::MatrixXd matrix,
                            ReadMatrix(&value, rows, 4, entry));
    const Eigen::Matrix3d rotation = matrix.topLeftCorner<3, 3>();
    FREEGS_RETURN_IF_ERROR(CheckRotation(rotation, entry));
    if (rows == 4 && matrix.row(3) != Eigen::RowVector4d(0, 0, 0, 1)) {
      return BadInputError(entry + ": the last row must be 0 0 0 1");
    }
    View view;
    view.name = name;
    view.camera = camera;
    view.cam_from_world.rotation =
        Eigen::Quaterniond(NearestRotation(rotation));
    view.cam_from_world.translation = matrix.topRightCorner<3, 1>();
    if (view.cam_from_world.translation.cwiseAbs().maxCoeff() >
        kMaxTranslation) {
      return BadInputError(entry + ": the translation is too large");
    }
    views.push_back(std::move(view));
  }
  std::ranges::sort(views, NaturalLess, &View::name);
  return views;
}

// The view of a frame of a transforms.json.
StatusOr<View> ViewOf(const sfm::TransformsFrame& frame) {
  View view;
  view.name = fs::path(frame.file_path).lexically_normal().string();
  if (!IsNameBelowFolder(view.name)) {
    return BadInputError("not the name of a photo in its folder");
  }
  const double width = frame.intrinsics.width;
  const double height = frame.intrinsics.height;
  if (!(width >= 1 && width <= 65535 && height >= 1 && height <= 65535)) {
    return BadInputError("needs \"w\" and \"h\", from 1 to 65535");
  }
  FREEGS_ASSIGN_OR_RETURN(
      const sfm::Camera camera,
      sfm::MakeCamera(
          frame.intrinsics, static_cast<int>(width), static_cast<int>(height)));
  if (!camera.IsUndistorted()) {
    return BadInputError("has distortion, and pictures have none");
  }
  view.camera = sfm::PinholeOf(camera);
  view.cam_from_world = frame.cam_from_world;
  if (view.cam_from_world.translation.cwiseAbs().maxCoeff() > kMaxTranslation) {
    return BadInputError("the translation is too large");
  }
  return view;
}

StatusOr<CameraSet> ParseTransformsViews(std::string_view text,
                                         const std::string& source) {
  const StatusOr<sfm::TransformsFile> file = sfm::ParseTransforms(text);
  if (!file.ok()) return file.status().Annotated(source);
  CameraSet cameras;
  for (const sfm::TransformsFrame& frame : file->frames) {
    StatusOr<View> view = ViewOf(frame);
    if (!view.ok()) {
      return view.status().Annotated(source + ": frame \"" + frame.file_path +
                                     "\"");
    }
    const bool test = std::ranges::find(file->holdout, frame.file_path) !=
                      file->holdout.end();
    (test ? cameras.test : cameras.train).push_back(*std::move(view));
  }
  std::ranges::sort(cameras.train, NaturalLess, &View::name);
  std::ranges::sort(cameras.test, NaturalLess, &View::name);
  return cameras;
}

}  // namespace

StatusOr<CameraSet> ParseCameraSet(std::string_view text,
                                   const std::string& source) {
  FREEGS_ASSIGN_OR_RETURN(const json document, ParseJsonObject(text, source));
  if (FindField(document, "frames") != nullptr) {
    return ParseTransformsViews(text, source);
  }
  FREEGS_ASSIGN_OR_RETURN(
      const Pinhole camera,
      ReadIntrinsics(FindField(document, "intrinsics"), source));
  CameraSet cameras;
  const json* train = FindField(document, "train");
  const json* test = FindField(document, "test");
  if (train == nullptr && test == nullptr) {
    return BadInputError(source + ": neither \"train\" nor \"test\" views");
  }
  if (train != nullptr) {
    FREEGS_ASSIGN_OR_RETURN(cameras.train,
                            ReadViews(*train, camera, source + ": train"));
  }
  if (test != nullptr) {
    FREEGS_ASSIGN_OR_RETURN(cameras.test,
                            ReadViews(*test, camera, source + ": test"));
  }
  return cameras;
}

StatusOr<CameraSet> ReadCameraSet(const fs::path& path) {
  FREEGS_ASSIGN_OR_RETURN(const std::string text,
                          ReadFile(path, kMaxCameraFileBytes));
  return ParseCameraSet(text, path.string());
}

}  // namespace freegs::stages
