// SPDX-License-Identifier: BSD-3-Clause

#include "stages/ground_truth.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <system_error>
#include <utility>

#include <Eigen/Geometry>
#include <nlohmann/json.hpp>

#include "core/files.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr uint64_t kMaxFileBytes = uint64_t{1} << 28;
constexpr double kRotationTolerance = 1e-3;

StatusOr<json> ParseObject(std::string_view text, const std::string& source) {
  json document = json::parse(text, /*cb=*/nullptr, /*allow_exceptions=*/false);
  if (document.is_discarded()) {
    return BadInputError(source + ": not valid JSON");
  }
  if (!document.is_object()) {
    return BadInputError(source + ": the top level must be an object");
  }
  return document;
}

// Null when there is none.
const json* Find(const json& object, const char* key) {
  if (!object.is_object()) return nullptr;
  const auto found = object.find(key);
  return found == object.end() ? nullptr : &*found;
}

StatusOr<double> ReadNumber(const json* value, const std::string& where) {
  if (value == nullptr || !value->is_number()) {
    return BadInputError(where + ": must be a number");
  }
  const double number = value->get<double>();
  if (!std::isfinite(number)) {
    return BadInputError(where + ": must be finite");
  }
  return number;
}

StatusOr<int> ReadInteger(const json* value,
                          int max,
                          const std::string& where) {
  FREEGS_ASSIGN_OR_RETURN(const double number, ReadNumber(value, where));
  if (number < 1 || number > max || number != std::floor(number)) {
    return BadInputError(where + ": must be a whole number in 1.." +
                         std::to_string(max));
  }
  return static_cast<int>(number);
}

// A list of lists of numbers: rows x columns.
StatusOr<Eigen::MatrixXd> ReadMatrix(const json& value,
                                     int rows,
                                     int columns,
                                     const std::string& where) {
  const std::string shape = where + ": must be " + std::to_string(rows) +
                            " rows of " + std::to_string(columns) + " numbers";
  if (!value.is_array() || value.size() != static_cast<size_t>(rows)) {
    return BadInputError(shape);
  }
  Eigen::MatrixXd matrix(rows, columns);
  for (int r = 0; r < rows; ++r) {
    const json& row = value[static_cast<size_t>(r)];
    if (!row.is_array() || row.size() != static_cast<size_t>(columns)) {
      return BadInputError(shape);
    }
    for (int c = 0; c < columns; ++c) {
      FREEGS_ASSIGN_OR_RETURN(matrix(r, c),
                              ReadNumber(&row[static_cast<size_t>(c)], where));
    }
  }
  return matrix;
}

StatusOr<Eigen::Vector3d> ReadVector(const json* value,
                                     const std::string& where) {
  if (value == nullptr || !value->is_array() || value->size() != 3) {
    return BadInputError(where + ": must be a list of three numbers");
  }
  Eigen::Vector3d vector;
  for (int i = 0; i < 3; ++i) {
    FREEGS_ASSIGN_OR_RETURN(
        vector[i], ReadNumber(&(*value)[static_cast<size_t>(i)], where));
  }
  return vector;
}

Status CheckRotation(const Eigen::Matrix3d& rotation,
                     const std::string& where) {
  const Eigen::Matrix3d product = rotation * rotation.transpose();
  if (!((product - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() <=
        kRotationTolerance) ||
      rotation.determinant() < 0) {
    return BadInputError(where + ": not a rotation matrix");
  }
  return Status();
}

StatusOr<Pinhole> ReadIntrinsics(const json* value, const std::string& source) {
  if (value == nullptr || !value->is_object()) {
    return BadInputError(source + ": \"intrinsics\" is missing");
  }
  const auto where = [&source](const char* key) {
    return source + ": intrinsics." + key;
  };
  Pinhole camera;
  FREEGS_ASSIGN_OR_RETURN(camera.width,
                          ReadInteger(Find(*value, "w"), 65535, where("w")));
  FREEGS_ASSIGN_OR_RETURN(camera.height,
                          ReadInteger(Find(*value, "h"), 65535, where("h")));
  FREEGS_ASSIGN_OR_RETURN(camera.fx,
                          ReadNumber(Find(*value, "fx"), where("fx")));
  camera.fy = camera.fx;
  camera.cx = 0.5 * camera.width;
  camera.cy = 0.5 * camera.height;
  for (const auto& [key, target] : {std::pair{"fy", &camera.fy},
                                    std::pair{"cx", &camera.cx},
                                    std::pair{"cy", &camera.cy}}) {
    const json* field = Find(*value, key);
    if (field == nullptr) continue;
    FREEGS_ASSIGN_OR_RETURN(*target, ReadNumber(field, where(key)));
  }
  if (camera.fx <= 0 || camera.fy <= 0) {
    return BadInputError(source + ": focal lengths must be positive");
  }
  return camera;
}

// A name that stays in the folder it is appended to.
bool IsPlainName(const std::string& name) {
  const fs::path path(name);
  if (!path.has_filename() || !path.is_relative()) return false;
  return std::none_of(path.begin(), path.end(), [](const fs::path& part) {
    return part == "..";
  });
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
    if (!IsPlainName(name)) {
      return BadInputError(entry + ": not the name of a photo");
    }
    const int rows = value.is_array() && value.size() == 3 ? 3 : 4;
    FREEGS_ASSIGN_OR_RETURN(const Eigen::MatrixXd matrix,
                            ReadMatrix(value, rows, 4, entry));
    const Eigen::Matrix3d rotation = matrix.topLeftCorner<3, 3>();
    FREEGS_RETURN_IF_ERROR(CheckRotation(rotation, entry));
    if (rows == 4 && matrix.row(3) != Eigen::RowVector4d(0, 0, 0, 1)) {
      return BadInputError(entry + ": the last row must be 0 0 0 1");
    }
    View view;
    view.name = name;
    view.camera = camera;
    view.cam_from_world.rotation = Eigen::Quaterniond(rotation).normalized();
    view.cam_from_world.translation = matrix.topRightCorner<3, 1>();
    views.push_back(std::move(view));
  }
  return views;
}

StatusOr<TrueObject> ReadTrueObject(const json& value,
                                    const std::string& where) {
  TrueObject object;
  FREEGS_ASSIGN_OR_RETURN(object.id,
                          ReadInteger(Find(value, "id"), 65535, where + ".id"));
  const json* label = Find(value, "label");
  if (label == nullptr || !label->is_string()) {
    return BadInputError(where + ".label: must be a text");
  }
  object.label = label->get<std::string>();
  const json* aabb = Find(value, "aabb");
  if (aabb == nullptr) return BadInputError(where + ".aabb: is missing");
  semantics::AxisAlignedBox bounds;
  FREEGS_ASSIGN_OR_RETURN(bounds.min,
                          ReadVector(Find(*aabb, "min"), where + ".aabb.min"));
  FREEGS_ASSIGN_OR_RETURN(bounds.max,
                          ReadVector(Find(*aabb, "max"), where + ".aabb.max"));
  if ((bounds.max - bounds.min).minCoeff() < 0) {
    return BadInputError(where + ".aabb: min is larger than max");
  }
  object.aabb = bounds;
  const json* obb = Find(value, "obb");
  if (obb == nullptr || obb->is_null()) return object;
  semantics::OrientedBox box;
  FREEGS_ASSIGN_OR_RETURN(
      box.center, ReadVector(Find(*obb, "center"), where + ".obb.center"));
  FREEGS_ASSIGN_OR_RETURN(box.size,
                          ReadVector(Find(*obb, "size"), where + ".obb.size"));
  if (box.size.minCoeff() < 0) {
    return BadInputError(where + ".obb.size: must not be negative");
  }
  const json* rotation = Find(*obb, "rotation");
  FREEGS_ASSIGN_OR_RETURN(const Eigen::MatrixXd matrix,
                          ReadMatrix(rotation == nullptr ? json() : *rotation,
                                     3,
                                     3,
                                     where + ".obb.rotation"));
  box.rotation = matrix;
  FREEGS_RETURN_IF_ERROR(CheckRotation(box.rotation, where + ".obb.rotation"));
  object.obb = box;
  return object;
}

}  // namespace

StatusOr<CameraSet> ParseCameraSet(std::string_view text,
                                   const std::string& source) {
  FREEGS_ASSIGN_OR_RETURN(const json document, ParseObject(text, source));
  FREEGS_ASSIGN_OR_RETURN(const Pinhole camera,
                          ReadIntrinsics(Find(document, "intrinsics"), source));
  CameraSet cameras;
  const json* train = Find(document, "train");
  const json* test = Find(document, "test");
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
                          ReadFile(path, kMaxFileBytes));
  return ParseCameraSet(text, path.string());
}

StatusOr<std::vector<TrueObject>> ParseTrueObjects(std::string_view text,
                                                   const std::string& source) {
  FREEGS_ASSIGN_OR_RETURN(const json document, ParseObject(text, source));
  const json* list = Find(document, "objects");
  if (list == nullptr || !list->is_array()) {
    return BadInputError(source + ": \"objects\" must be a list");
  }
  std::vector<TrueObject> objects;
  std::set<int> ids;
  for (size_t i = 0; i < list->size(); ++i) {
    const std::string where = source + ": objects[" + std::to_string(i) + "]";
    FREEGS_ASSIGN_OR_RETURN(TrueObject object,
                            ReadTrueObject((*list)[i], where));
    if (!ids.insert(object.id).second) {
      return BadInputError(where + ".id: used twice");
    }
    objects.push_back(std::move(object));
  }
  std::sort(
      objects.begin(),
      objects.end(),
      [](const TrueObject& a, const TrueObject& b) { return a.id < b.id; });
  return objects;
}

StatusOr<std::vector<TrueObject>> ReadTrueObjects(const fs::path& path) {
  FREEGS_ASSIGN_OR_RETURN(const std::string text,
                          ReadFile(path, kMaxFileBytes));
  return ParseTrueObjects(text, path.string());
}

StatusOr<GroundTruth> ReadGroundTruth(const fs::path& folder) {
  std::error_code error;
  GroundTruth truth;
  truth.folder = folder;
  if (!fs::exists(folder / "gt" / "cameras.json", error) &&
      fs::exists(folder / "cameras.json", error)) {
    // The gt folder itself; "gt/" and "gt" alike.
    fs::path inner = fs::absolute(folder, error).lexically_normal();
    if (!inner.has_filename()) inner = inner.parent_path();
    truth.folder = inner.parent_path();
    if (inner.filename() != "gt") {
      return BadInputError(folder.string() +
                           ": cameras.json must lie in a folder named gt");
    }
  }
  FREEGS_ASSIGN_OR_RETURN(truth.cameras,
                          ReadCameraSet(truth.folder / "gt" / "cameras.json"));
  const fs::path objects = truth.folder / "gt" / "objects.json";
  if (fs::exists(objects, error)) {
    FREEGS_ASSIGN_OR_RETURN(truth.objects, ReadTrueObjects(objects));
  }
  for (const View& view : truth.cameras.test) {
    const fs::path photo = truth.folder / "test" / "images" / view.name;
    if (fs::exists(photo, error)) truth.photos[view.name] = photo;
    const fs::path ids = truth.folder / "gt" / "instance" /
                         fs::path(view.name).replace_extension(".png");
    if (fs::exists(ids, error)) truth.masks[view.name] = {{ids, 0}};
  }
  truth.complete = true;
  return truth;
}

}  // namespace freegs::stages
