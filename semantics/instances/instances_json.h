// SPDX-License-Identifier: BSD-3-Clause
// The file instances.json: the list of instances, for programs and people.

#ifndef FREEGS_SEMANTICS_INSTANCES_INSTANCES_JSON_H_
#define FREEGS_SEMANTICS_INSTANCES_INSTANCES_JSON_H_

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "core/status.h"
#include "semantics/instances/instances.h"

namespace freegs::semantics {

// [{"id": 1, "num_gaussians": 812, "centre": [x, y, z],
//   "aabb": {"min": [x, y, z], "max": [x, y, z]},
//   "obb": {"center": [x, y, z], "size": [x, y, z],
//           "rotation": [[...], [...], [...]]},   rows; columns are the sides
//   "score": 0.83, "background": false, "words": ["red apple"]}, ...]
// World frame of the camera poses.
std::string SerializeInstances(const std::vector<Instance>& instances);

// One entry of that list.
nlohmann::json InstanceToJson(const Instance& instance);

// The file holds the text of SerializeInstances().
Status WriteInstances(const std::filesystem::path& path,
                      const std::vector<Instance>& instances);

// kBadInput, which names the fault, for malformed JSON, for numbers that are
// missing or not finite, and for ids below 1 or used twice. The members
// "background" and "words" may be missing; unknown members are ignored.
StatusOr<std::vector<Instance>> ParseInstances(std::string_view text);
StatusOr<std::vector<Instance>> ReadInstances(
    const std::filesystem::path& path);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_INSTANCES_INSTANCES_JSON_H_
