// SPDX-License-Identifier: BSD-3-Clause

#include "stages/export/instance_files.h"

#include <utility>

#include <nlohmann/json.hpp>

#include "core/io/json_fields.h"
#include "core/io/json_text.h"

namespace freegs::stages {
namespace {

std::string CategoryName(const semantics::Instance& instance) {
  return instance.words.empty() ? "object" : instance.words.front();
}

}  // namespace

std::string InstanceName(const semantics::Instance& instance) {
  return instance.words.empty() ? "instance " + std::to_string(instance.id)
                                : instance.words.front();
}

std::string BoxesJson(const std::vector<semantics::Instance>& instances) {
  nlohmann::json objects = nlohmann::json::array();
  for (const semantics::Instance& instance : instances) {
    nlohmann::json rotation = nlohmann::json::array();
    for (int row = 0; row < 3; ++row) {
      rotation.push_back(
          VectorJson(instance.obb.rotation.row(row).transpose()));
    }
    objects.push_back({{"id", instance.id},
                       {"label", InstanceName(instance)},
                       {"background", instance.background},
                       {"aabb",
                        {{"min", VectorJson(instance.aabb.min)},
                         {"max", VectorJson(instance.aabb.max)}}},
                       {"obb",
                        {{"center", VectorJson(instance.obb.centre)},
                         {"size", VectorJson(instance.obb.size)},
                         {"rotation", std::move(rotation)}}}});
  }
  return JsonText({{"objects", std::move(objects)}});
}

CocoMasks::CocoMasks(std::vector<semantics::Instance> instances)
    : instances_(std::move(instances)) {
  for (size_t k = 0; k < instances_.size(); ++k) {
    instance_of_label_[instances_[k].id - 1] = k;
  }
}

void CocoMasks::AddPicture(const std::string& file_name,
                           const Image<int32_t>& labels) {
  for (auto& [label, mask] : MasksOfLabels(labels)) {
    const auto instance = instance_of_label_.find(label);
    if (instance == instance_of_label_.end()) continue;
    annotations_.push_back({pictures_.size(), instance->second, mask});
  }
  pictures_.push_back({file_name, labels.width(), labels.height()});
}

std::string CocoMasks::Json() const {
  std::map<std::string, int> categories;
  for (const semantics::Instance& instance : instances_) {
    categories[CategoryName(instance)] = 0;
  }
  nlohmann::json file = {{"images", nlohmann::json::array()},
                         {"annotations", nlohmann::json::array()},
                         {"categories", nlohmann::json::array()}};
  for (auto& [name, id] : categories) {
    id = static_cast<int>(file["categories"].size()) + 1;
    file["categories"].push_back({{"id", id}, {"name", name}});
  }
  for (const Picture& picture : pictures_) {
    file["images"].push_back({{"id", file["images"].size() + 1},
                              {"file_name", picture.file_name},
                              {"width", picture.width},
                              {"height", picture.height}});
  }
  for (const Annotation& annotation : annotations_) {
    const semantics::Instance& instance = instances_[annotation.instance];
    const Picture& picture = pictures_[annotation.picture];
    const LabelMask& mask = annotation.mask;
    file["annotations"].push_back(
        {{"id", file["annotations"].size() + 1},
         {"image_id", annotation.picture + 1},
         {"category_id", categories.at(CategoryName(instance))},
         {"segmentation",
          {{"size", {picture.height, picture.width}},
           {"counts", CompressRuns(mask.runs)}}},
         {"area", mask.area},
         {"bbox",
          {mask.left,
           mask.top,
           mask.right - mask.left,
           mask.bottom - mask.top}},
         {"iscrowd", 0},
         {"instance_id", instance.id},
         {"background", instance.background}});
  }
  return JsonText(file, -1);
}

}  // namespace freegs::stages
