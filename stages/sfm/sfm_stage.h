// SPDX-License-Identifier: BSD-3-Clause
// ingest/ -> sfm/: cameras and points, by COLMAP or imported.

#ifndef FREEGS_STAGES_SFM_SFM_STAGE_H_
#define FREEGS_STAGES_SFM_SFM_STAGE_H_

#include <cstdint>
#include <memory>
#include <string>

#include "pipeline/option_table.h"
#include "pipeline/stage.h"
#include "sfm/mapping/health.h"
#include "sfm/mapping/structure_from_motion.h"

namespace freegs::stages {

struct SfmStageOptions {
  // num_threads is set from the stage's thread pool.
  sfm::SfmOptions colmap;
  sfm::HealthOptions health;

  // A COLMAP model folder or a transforms.json to take instead of running
  // COLMAP; empty for none.
  std::string import;

  // Points to start from when the import has none.
  int random_points = 10000;
};

void RegisterSfmOptions(SfmStageOptions& options, pipeline::OptionTable& table);

std::unique_ptr<pipeline::Stage> MakeSfmStage(const SfmStageOptions& options,
                                              uint64_t seed);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_SFM_SFM_STAGE_H_
