// SPDX-License-Identifier: BSD-3-Clause
// The options of stage bootstrap, and how the method is told them.

#ifndef FREEGS_STAGES_BOOTSTRAP_BOOTSTRAP_OPTIONS_H_
#define FREEGS_STAGES_BOOTSTRAP_BOOTSTRAP_OPTIONS_H_

#include <string>

#include "core/status.h"
#include "pipeline/option_table.h"
#include "semantics/field/bootstrapping.h"

namespace freegs::stages {

struct BootstrapStageOptions {
  // lift: semantic vectors are averaged from the photographs' features.
  // paper: they are trained from there. geometry: there are none.
  std::string mode = "lift";
  // evidence or union; becomes method.clustering.method.
  std::string clustering = "evidence";
  // Folder of a CLIP model; empty for the one that comes with the program.
  std::string model;
  // What the method is told, except for what the members here decide.
  semantics::BootstrappingOptions method;
  // Memory for blending weights, in GB (10^9 bytes).
  double weights_memory_gb = 1;
  // So many photographs, evenly spread, get a coloured preview.
  int num_previews = 6;
};

// Adds section [bootstrap] to the table, which keeps pointers to `options`.
void RegisterBootstrapOptions(BootstrapStageOptions& options,
                              pipeline::OptionTable& table);

// Translates the options for the method. kInvalidArgument for a value that is
// not allowed.
StatusOr<semantics::BootstrappingOptions> MakeBootstrappingOptions(
    const BootstrapStageOptions& options);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_BOOTSTRAP_BOOTSTRAP_OPTIONS_H_
