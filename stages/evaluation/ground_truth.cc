// SPDX-License-Identifier: BSD-3-Clause

#include "stages/evaluation/ground_truth.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <system_error>
#include <utility>

#include <Eigen/Geometry>
#include <nlohmann/json.hpp>

#include "core/io/files.h"
#include "core/io/json_fields.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr uint64_t kMaxFileBytes = uint64_t{1} << 28;

StatusOr<TrueObject> ReadTrueObject(const json& value,
                                    const std::string& where) {
  TrueObject object;
  FREEGS_ASSIGN_OR_RETURN(
      object.id, ReadInteger(FindField(value, "id"), 1, 65535, where + ".id"));
  const json* label = FindField(value, "label");
  if (label == nullptr || !label->is_string()) {
    return BadInputError(where + ".label: must be a text");
  }
  object.label = label->get<std::string>();
  const json* aabb = FindField(value, "aabb");
  if (aabb == nullptr) return BadInputError(where + ".aabb: is missing");
  semantics::AxisAlignedBox bounds;
  FREEGS_ASSIGN_OR_RETURN(
      bounds.min, ReadVector3(FindField(*aabb, "min"), where + ".aabb.min"));
  FREEGS_ASSIGN_OR_RETURN(
      bounds.max, ReadVector3(FindField(*aabb, "max"), where + ".aabb.max"));
  if ((bounds.max - bounds.min).minCoeff() < 0) {
    return BadInputError(where + ".aabb: min is larger than max");
  }
  object.aabb = bounds;
  return object;
}

}  // namespace

StatusOr<std::vector<TrueObject>> ParseTrueObjects(std::string_view text,
                                                   const std::string& source) {
  FREEGS_ASSIGN_OR_RETURN(const json document, ParseJsonObject(text, source));
  const json* list = FindField(document, "objects");
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
    // `folder` is the gt folder itself, written "gt/" or "gt".
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
