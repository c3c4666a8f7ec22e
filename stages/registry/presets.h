// SPDX-License-Identifier: BSD-3-Clause
// Named sets of option values. An option that a preset does not name stays at
// its default; config.ini and the command line override presets.

#ifndef FREEGS_STAGES_REGISTRY_PRESETS_H_
#define FREEGS_STAGES_REGISTRY_PRESETS_H_

#include <string>
#include <vector>

#include "core/status.h"
#include "pipeline/option_table.h"

namespace freegs::stages {

// The names of the presets that have values: fast, balanced and quality.
std::vector<std::string> PresetNames();

// The preset that has no values of its own: `run --within` and `run --at-least`
// choose them.
inline constexpr char kAutoPreset[] = "auto";

// What option general.preset may be: the names, and kAutoPreset.
std::vector<std::string> PresetChoices();

// Returns the settings of a preset; kInvalidArgument for an unknown name.
StatusOr<std::vector<pipeline::OptionSetting>> PresetSettings(
    const std::string& name);

// The value of reconstruct.densify_interval for a training of so many
// iterations: as in the presets, a short training densifies as often as a long
// one.
int DensifyInterval(int iterations);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_REGISTRY_PRESETS_H_
