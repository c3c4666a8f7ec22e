// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/instances/instances_json.h"

#include <cmath>
#include <set>

#include <nlohmann/json.hpp>

#include "core/io/files.h"

namespace freegs::semantics {
namespace {

using nlohmann::json;

constexpr uint64_t kMaxFileSize = uint64_t{1} << 28;

json ToJson(const Eigen::Vector3d& x) { return {x[0], x[1], x[2]}; }

bool IsInteger(const json& value) { return value.is_number_integer(); }

bool ReadNumber(const json& value, double* out) {
  if (!value.is_number()) return false;
  *out = value.get<double>();
  return std::isfinite(*out);
}

bool ReadVector(const json& value, Eigen::Vector3d* out) {
  if (!value.is_array() || value.size() != 3) return false;
  for (int k = 0; k < 3; ++k) {
    if (!ReadNumber(value[k], &(*out)[k])) return false;
  }
  return true;
}

// A member of an object, or null.
json Member(const json& object, const char* name) {
  if (!object.is_object()) return nullptr;
  const auto it = object.find(name);
  return it == object.end() ? json(nullptr) : *it;
}

Status ReadInstance(const json& entry, Instance* instance) {
  const auto fault = [](const char* member) {
    return BadInputError(std::string("\"") + member +
                         "\" is missing or malformed");
  };
  const json id = Member(entry, "id");
  if (!IsInteger(id) || id < 1 || id > 0x7fffffff) return fault("id");
  instance->id = id.get<int>();
  const json count = Member(entry, "num_gaussians");
  if (!IsInteger(count) || count < 0 || count > int64_t{1} << 40) {
    return fault("num_gaussians");
  }
  instance->num_gaussians = count.get<int64_t>();
  if (!ReadVector(Member(entry, "centre"), &instance->centre)) {
    return fault("centre");
  }
  const json aabb = Member(entry, "aabb");
  if (!ReadVector(Member(aabb, "min"), &instance->aabb.min) ||
      !ReadVector(Member(aabb, "max"), &instance->aabb.max)) {
    return fault("aabb");
  }
  const json obb = Member(entry, "obb");
  const json rotation = Member(obb, "rotation");
  if (!ReadVector(Member(obb, "center"), &instance->obb.center) ||
      !ReadVector(Member(obb, "size"), &instance->obb.size) ||
      !rotation.is_array() || rotation.size() != 3) {
    return fault("obb");
  }
  for (int row = 0; row < 3; ++row) {
    Eigen::Vector3d values;
    if (!ReadVector(rotation[row], &values)) return fault("obb");
    instance->obb.rotation.row(row) = values.transpose();
  }
  if (!ReadNumber(Member(entry, "score"), &instance->score)) {
    return fault("score");
  }
  const json background = Member(entry, "background");
  if (!background.is_null()) {
    if (!background.is_boolean()) return fault("background");
    instance->background = background.get<bool>();
  }
  const json words = Member(entry, "words");
  if (words.is_null()) return {};
  if (!words.is_array()) return fault("words");
  for (const json& word : words) {
    if (!word.is_string()) return fault("words");
    instance->words.push_back(word.get<std::string>());
  }
  return {};
}

}  // namespace

std::string SerializeInstances(const std::vector<Instance>& instances) {
  json list = json::array();
  for (const Instance& instance : instances) {
    json rotation = json::array();
    for (int row = 0; row < 3; ++row) {
      rotation.push_back(ToJson(instance.obb.rotation.row(row).transpose()));
    }
    list.push_back({{"id", instance.id},
                    {"num_gaussians", instance.num_gaussians},
                    {"centre", ToJson(instance.centre)},
                    {"aabb",
                     {{"min", ToJson(instance.aabb.min)},
                      {"max", ToJson(instance.aabb.max)}}},
                    {"obb",
                     {{"center", ToJson(instance.obb.center)},
                      {"size", ToJson(instance.obb.size)},
                      {"rotation", std::move(rotation)}}},
                    {"score", instance.score},
                    {"background", instance.background},
                    {"words", instance.words}});
  }
  // Words are user-visible text: anything that is not UTF-8 is replaced.
  return list.dump(1, ' ', false, json::error_handler_t::replace) + "\n";
}

Status WriteInstances(const std::filesystem::path& path,
                      const std::vector<Instance>& instances) {
  return WriteFileAtomic(path, SerializeInstances(instances));
}

StatusOr<std::vector<Instance>> ParseInstances(std::string_view text) {
  const json list = json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (!list.is_array()) return BadInputError("this is not a list in JSON");
  std::vector<Instance> instances;
  std::set<int> ids;
  for (const json& entry : list) {
    Instance instance;
    const Status status = ReadInstance(entry, &instance);
    if (!status.ok()) {
      return status.Annotated("entry " + std::to_string(instances.size()));
    }
    if (!ids.insert(instance.id).second) {
      return BadInputError("id " + std::to_string(instance.id) +
                           " is used twice");
    }
    instances.push_back(std::move(instance));
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
