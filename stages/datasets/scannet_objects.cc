// SPDX-License-Identifier: BSD-3-Clause

#include "stages/datasets/scannet_objects.h"

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <sstream>
#include <unordered_map>
#include <utility>

#include <Eigen/Geometry>
#include <nlohmann/json.hpp>

#include "core/io/json_fields.h"

namespace freegs::stages {
namespace {

using Eigen::Vector3d;
using nlohmann::json;

constexpr int kMaxObjects = 65535;
constexpr int64_t kMaxSegment = int64_t{1} << 52;

// The labels that annotators give to the room itself.
bool IsStructure(const std::string& label) {
  static const std::set<std::string> kLabels = {"wall", "floor", "ceiling"};
  return kLabels.contains(label);
}

// Parses a JSON object and returns the list under `key`.
StatusOr<json> ParseList(std::string_view text,
                         const char* key,
                         const std::string& source) {
  FREEGS_ASSIGN_OR_RETURN(json document, ParseJsonObject(text, source));
  const auto found = document.find(key);
  if (found == document.end() || !found->is_array()) {
    return BadInputError(source + ": \"" + key + "\" must be a list");
  }
  return std::move(*found);
}

StatusOr<std::vector<int64_t>> ReadIntegers(const json& list,
                                            const std::string& where) {
  std::vector<int64_t> values;
  values.reserve(list.size());
  for (const json& value : list) {
    FREEGS_ASSIGN_OR_RETURN(
        const int64_t number,
        ReadInteger64(&value, -kMaxSegment, kMaxSegment, where));
    values.push_back(number);
  }
  return values;
}

}  // namespace

StatusOr<std::vector<int64_t>> ParseScannetSegments(std::string_view text,
                                                    const std::string& source) {
  FREEGS_ASSIGN_OR_RETURN(const json list,
                          ParseList(text, "segIndices", source));
  return ReadIntegers(list, source + ": segIndices");
}

StatusOr<std::vector<ScannetGroup>> ParseScannetGroups(
    std::string_view text, const std::string& source) {
  FREEGS_ASSIGN_OR_RETURN(const json list,
                          ParseList(text, "segGroups", source));
  std::vector<ScannetGroup> groups;
  std::set<int> ids;
  for (size_t i = 0; i < list.size(); ++i) {
    const json& value = list[i];
    const std::string path = "segGroups[" + std::to_string(i) + "]";
    Status status;
    JsonObjectReader reader(value, source, path, &status);
    ScannetGroup group;
    group.id = reader.Integer("objectId", 0, kMaxObjects - 1) + 1;
    group.label = reader.Text("label");
    const json& segments = reader.List("segments");
    FREEGS_RETURN_IF_ERROR(status);
    FREEGS_ASSIGN_OR_RETURN(group.segments,
                            ReadIntegers(segments, reader.Where("segments")));
    std::ranges::sort(group.segments);
    group.segments.erase(
        std::unique(group.segments.begin(), group.segments.end()),
        group.segments.end());
    if (!ids.insert(group.id).second) {
      return BadInputError(reader.Where("objectId") + ": used twice");
    }
    groups.push_back(std::move(group));
  }
  return groups;
}

StatusOr<Eigen::Matrix4d> ParseScannetAlignment(std::string_view text,
                                                const std::string& source) {
  std::istringstream lines{std::string(text)};
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string key;
    std::string equals;
    if (!(words >> key >> equals) || key != "axisAlignment") continue;
    Eigen::Matrix4d matrix;
    for (int k = 0; k < 16; ++k) {
      if (equals == "=" && words >> matrix(k / 4, k % 4)) continue;
      return BadInputError(source + ": axisAlignment must be 16 numbers");
    }
    const Eigen::Matrix3d rotation = matrix.topLeftCorner<3, 3>();
    // The files have six digits.
    FREEGS_RETURN_IF_ERROR(CheckRotation(rotation, source + ": axisAlignment"));
    if (!matrix.allFinite() ||
        matrix.row(3) != Eigen::RowVector4d(0, 0, 0, 1)) {
      return BadInputError(source +
                           ": axisAlignment is not a rotation and "
                           "translation");
    }
    return matrix;
  }
  return Eigen::Matrix4d(Eigen::Matrix4d::Identity());
}

StatusOr<std::vector<TrueObject>> ScannetBoxes(
    const std::vector<Vector3d>& vertices,
    const std::vector<int64_t>& segments,
    const std::vector<ScannetGroup>& groups,
    const Eigen::Matrix4d& alignment) {
  if (vertices.size() != segments.size()) {
    return InvalidArgumentError(std::to_string(segments.size()) +
                                " segment numbers for " +
                                std::to_string(vertices.size()) + " vertices");
  }
  // The time grows with the number of vertices plus that of the groups'
  // segments, because segments that several groups share are gone through once.
  const auto extend = [](auto* boxes, const auto& key, const auto& by) {
    const auto [box, is_new] = boxes->try_emplace(key, by);
    if (is_new) return;
    box->second.min = box->second.min.cwiseMin(by.min);
    box->second.max = box->second.max.cwiseMax(by.max);
  };
  std::unordered_map<int64_t, semantics::AxisAlignedBox> boxes_of_segments;
  for (size_t i = 0; i < vertices.size(); ++i) {
    const Vector3d point = (alignment * vertices[i].homogeneous()).head<3>();
    extend(&boxes_of_segments,
           segments[i],
           semantics::AxisAlignedBox{point, point});
  }
  std::map<size_t, semantics::AxisAlignedBox> boxes;
  for (size_t g = 0; g < groups.size(); ++g) {
    if (IsStructure(groups[g].label)) continue;
    for (const int64_t segment : groups[g].segments) {
      const auto found = boxes_of_segments.find(segment);
      if (found != boxes_of_segments.end()) extend(&boxes, g, found->second);
    }
  }
  std::vector<TrueObject> objects;
  for (const auto& [g, box] : boxes) {
    objects.push_back({groups[g].id, groups[g].label, box});
  }
  std::sort(
      objects.begin(),
      objects.end(),
      [](const TrueObject& a, const TrueObject& b) { return a.id < b.id; });
  return objects;
}

}  // namespace freegs::stages
