// SPDX-License-Identifier: BSD-3-Clause
// reconstruct/ -> bootstrap/: phase 2, an instance index for every Gaussian.

#ifndef FREEGS_STAGES_BOOTSTRAP_STAGE_H_
#define FREEGS_STAGES_BOOTSTRAP_STAGE_H_

#include <cstdint>
#include <memory>
#include <string>

#include "pipeline/option_table.h"
#include "pipeline/stage.h"
#include "semantics/instance_clustering.h"

namespace freegs::stages {

struct BootstrapStageOptions {
  semantics::InstanceClusteringOptions clustering;
  std::string method = "eom";  // Or "leaf": clustering.hdbscan.method.
  // Longest side in pixels of the instance maps; 0 is the photographs' size.
  int max_image_size = 0;
  // Photographs, evenly spread, that get a coloured preview.
  int num_previews = 6;
};

void RegisterBootstrapOptions(BootstrapStageOptions& options,
                              pipeline::OptionTable& table);

// Reads reconstruct/point_cloud.ply and undistort/; writes idsf.bin (no
// features yet), instances.json, metrics.json, instances/VIEW.png (16-bit grey,
// instance id, 0 = none) for every view and preview/VIEW.png for a few.
std::unique_ptr<pipeline::Stage> MakeBootstrapStage(
    const BootstrapStageOptions& options, uint64_t seed);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_BOOTSTRAP_STAGE_H_
