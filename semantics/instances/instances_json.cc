// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/instances/instances_json.h"

#include <limits>
#include <set>

#include <nlohmann/json.hpp>

#include "core/io/files.h"
#include "core/io/json_fields.h"
#include "core/io/json_text.h"

namespace freegs::semantics {
namespace {

using nlohmann::json;

constexpr uint64_t kMaxFileSize = uint64_t{1} << 28;

json ToJson(const Eigen::Vector3d& x) { return {x[0], x[1], x[2]}; }

Instance ReadInstance(const json& entry,
                      const std::string& path,
                      Status* status) {
  JsonObjectReader reader(entry, "", path, status);
  Instance instance;
  instance.id = reader.Integer("id", 1, 0x7fffffff);
  instance.num_gaussians =
      reader.Integer64("num_gaussians", 0, int64_t{1} << 40);
  instance.centre = reader.Vector3("centre");
  JsonObjectReader aabb(reader.Object("aabb"), "", path + ".aabb", status);
  instance.aabb.min = aabb.Vector3("min");
  instance.aabb.max = aabb.Vector3("max");
  JsonObjectReader obb(reader.Object("obb"), "", path + ".obb", status);
  instance.obb.centre = obb.Vector3("center");
  instance.obb.size = obb.Vector3("size");
  instance.obb.rotation = obb.Matrix("rotation", 3, 3);
  constexpr double kMaxScore = std::numeric_limits<double>::max();
  instance.score = reader.Number("score", -kMaxScore, kMaxScore);
  if (reader.Has("background") && !reader.IsNull("background")) {
    instance.background = reader.Bool("background");
  }
  if (!reader.Has("words") || reader.IsNull("words")) return instance;
  for (const json& word : reader.List("words")) {
    if (word.is_string()) {
      instance.words.push_back(word.get<std::string>());
    } else {
      reader.Fail("words", "must be a list of texts");
    }
  }
  return instance;
}

}  // namespace

json InstanceToJson(const Instance& instance) {
  json rotation = json::array();
  for (int row = 0; row < 3; ++row) {
    rotation.push_back(ToJson(instance.obb.rotation.row(row).transpose()));
  }
  return {{"id", instance.id},
          {"num_gaussians", instance.num_gaussians},
          {"centre", ToJson(instance.centre)},
          {"aabb",
           {{"min", ToJson(instance.aabb.min)},
            {"max", ToJson(instance.aabb.max)}}},
          {"obb",
           {{"center", ToJson(instance.obb.centre)},
            {"size", ToJson(instance.obb.size)},
            {"rotation", std::move(rotation)}}},
          {"score", instance.score},
          {"background", instance.background},
          {"words", instance.words}};
}

std::string SerializeInstances(const std::vector<Instance>& instances) {
  json list = json::array();
  for (const Instance& instance : instances) {
    list.push_back(InstanceToJson(instance));
  }
  return JsonText(list, 1);
}

Status WriteInstances(const std::filesystem::path& path,
                      const std::vector<Instance>& instances) {
  return WriteFileAtomic(path, SerializeInstances(instances));
}

StatusOr<std::vector<Instance>> ParseInstances(std::string_view text) {
  FREEGS_ASSIGN_OR_RETURN(const json list, ParseJson(text));
  if (!list.is_array()) {
    return BadInputError("the top level must be a list");
  }
  std::vector<Instance> instances;
  std::set<int> ids;
  Status status;
  for (const json& entry : list) {
    const std::string path = "entry " + std::to_string(instances.size());
    instances.push_back(ReadInstance(entry, path, &status));
    FREEGS_RETURN_IF_ERROR(status);
    const int id = instances.back().id;
    if (!ids.insert(id).second) {
      return BadInputError("id " + std::to_string(id) + " is used twice");
    }
  }
  return instances;
}

StatusOr<std::vector<Instance>> ReadInstances(
    const std::filesystem::path& path) {
  FREEGS_ASSIGN_OR_RETURN(const std::string text, ReadFile(path, kMaxFileSize));
  auto instances = ParseInstances(text);
  if (!instances.ok()) return instances.status().Annotated(path.string());
  return instances;
}

}  // namespace freegs::semantics
