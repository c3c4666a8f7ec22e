// SPDX-License-Identifier: BSD-3-Clause

#include "stages/registry/presets.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace freegs::stages {
namespace {

using Values = std::vector<std::pair<std::string, std::string>>;

// Preset -> {option, value}. Preset balanced changes no default.
const std::map<std::string, Values>& Presets() {
  static const std::map<std::string, Values> presets = {
      {"fast",
       {{"sfm.max_features", "1200"},
        {"reconstruct.iterations", "1500"},
        {"reconstruct.max_image_size", "640"},
        {"reconstruct.budget", "auto:50000"},
        {"reconstruct.densify_interval", "45"}}},
      {"balanced", {}},
      {"quality",
       {{"sfm.max_features", "4000"},
        {"reconstruct.iterations", "5000"},
        {"reconstruct.max_image_size", "1600"},
        {"reconstruct.sh_degree", "3"},
        {"reconstruct.densify_interval", "100"}}},
  };
  return presets;
}

}  // namespace

std::vector<std::string> PresetNames() {
  return {"fast", "balanced", "quality"};
}

std::vector<std::string> PresetChoices() {
  std::vector<std::string> choices = PresetNames();
  choices.emplace_back(kAutoPreset);
  return choices;
}

StatusOr<std::vector<pipeline::OptionSetting>> PresetSettings(
    const std::string& name) {
  const auto preset = Presets().find(name);
  if (preset == Presets().end()) {
    return InvalidArgumentError("unknown preset '" + name +
                                "'; there are fast, balanced and quality");
  }
  std::vector<pipeline::OptionSetting> settings;
  for (const auto& [option, value] : preset->second) {
    settings.push_back({option, value, "preset " + name});
  }
  return settings;
}

int DensifyInterval(int iterations) {
  return std::clamp(static_cast<int>(std::lround(0.03 * iterations)), 10, 100);
}

}  // namespace freegs::stages
