// SPDX-License-Identifier: BSD-3-Clause

#include "stages/commands/instance_choice.h"

#include <charconv>
#include <system_error>
#include <utility>

#include "stages/scene/scene_instances.h"

namespace freegs::stages {
namespace {

// Ids of the option that is given; none when neither is.
StatusOr<std::vector<int>> ParseIds(const InstanceChoice& choice) {
  std::vector<int> ids;
  if (choice.everything()) return ids;
  if (!choice.only.empty() && !choice.without.empty()) {
    return InvalidArgumentError("--only and --without exclude each other");
  }
  const bool without = choice.only.empty();
  const std::string& text = without ? choice.without : choice.only;
  const char* at = text.data();
  const char* const end = at + text.size();
  while (true) {
    int id = 0;
    const auto [stop, error] = std::from_chars(at, end, id);
    if (error != std::errc() || (stop != end && *stop != ',')) {
      return InvalidArgumentError(
          std::string(without ? "--without" : "--only") + ": \"" + text +
          "\" is no list of instance ids like 3,17");
    }
    ids.push_back(id);
    if (stop == end) return ids;
    at = stop + 1;
  }
}

std::string OptionName(const InstanceChoice& choice) {
  return choice.only.empty() ? "--without" : "--only";
}

}  // namespace

StatusOr<std::set<int32_t>> ChosenLabels(const InstanceChoice& choice,
                                         std::span<const int32_t> labels) {
  FREEGS_ASSIGN_OR_RETURN(const std::vector<int> ids, ParseIds(choice));
  StatusOr<std::set<int32_t>> named = LabelsOfIds(labels, ids);
  if (!named.ok()) return named.status().Annotated(OptionName(choice));
  if (!choice.only.empty()) return named;
  std::set<int32_t> chosen(labels.begin(), labels.end());
  chosen.erase(-1);
  for (const int32_t label : *named) chosen.erase(label);
  return chosen;
}

StatusOr<std::vector<uint32_t>> ChosenGaussians(
    const InstanceChoice& choice, std::span<const int32_t> labels) {
  FREEGS_ASSIGN_OR_RETURN(std::set<int32_t> chosen,
                          ChosenLabels(choice, labels));
  if (choice.only.empty()) chosen.insert(-1);
  std::vector<uint32_t> gaussians;
  for (size_t i = 0; i < labels.size(); ++i) {
    if (chosen.contains(labels[i])) {
      gaussians.push_back(static_cast<uint32_t>(i));
    }
  }
  return gaussians;
}

Status CheckInstanceChoice(const InstanceChoice& choice) {
  return ParseIds(choice).status();
}

}  // namespace freegs::stages
