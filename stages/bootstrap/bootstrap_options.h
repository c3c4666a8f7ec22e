// SPDX-License-Identifier: BSD-3-Clause
// Options of stage bootstrap.

#ifndef FREEGS_STAGES_BOOTSTRAP_BOOTSTRAP_OPTIONS_H_
#define FREEGS_STAGES_BOOTSTRAP_BOOTSTRAP_OPTIONS_H_

#include <string>

#include "core/status.h"
#include "pipeline/option_table.h"
#include "semantics/field/bootstrapping.h"

namespace freegs::stages {

struct BootstrapStageOptions {
  // lift, paper or geometry.
  std::string mode = "lift";
  // Folder of a CLIP model; empty for the one that comes with the program.
  std::string model;
  semantics::BootstrappingOptions method;
  // eom or leaf: method.clustering.hdbscan.method.
  std::string selection = "eom";
  // Memory for blending weights, and disk space for those beyond.
  double weights_memory_gb = 1;
  double weights_disk_gb = 16;
  // Longest side in pixels of the instance maps; 0 is the photographs' size.
  int max_image_size = 0;
  // Photographs, evenly spread, that get a coloured preview.
  int num_previews = 6;
};

void RegisterBootstrapOptions(BootstrapStageOptions& options,
                              pipeline::OptionTable& table);

// What the method is told; kInvalidArgument when a value makes no sense.
StatusOr<semantics::BootstrappingOptions> MakeBootstrappingOptions(
    const BootstrapStageOptions& options);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_BOOTSTRAP_BOOTSTRAP_OPTIONS_H_
