// SPDX-License-Identifier: BSD-3-Clause
// Stage sfm, ingest/ -> sfm/: cameras and points of the photos, found by COLMAP
// or imported. MakeSfmStage makes the stage; stages/registry/stage_registry.h
// shows who runs it. The work itself is done by the library sfm
// (sfm/mapping/structure_from_motion.h, sfm/import/import_model.h).

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
  sfm::SfmOptions colmap;     // The stage sets num_threads to its pool's.
  sfm::HealthOptions health;  // What the result is judged by.

  // A COLMAP model folder or a transforms.json to take instead of running
  // COLMAP; empty runs COLMAP.
  std::string import;

  // So many random points are made when an import has no points. 0: points are
  // triangulated, and made at random only if these are few.
  int random_points = 0;
};

// Adds section [sfm] to the table, which keeps pointers to `options`.
void RegisterSfmOptions(SfmStageOptions& options, pipeline::OptionTable& table);

// Reads ingest/. Writes
//   sparse/0/, sparse/1/, ...   models in COLMAP's binary format, best first
//   health.json                 how far the result can be trusted, and why
//   frame.json                  a guess of the scene's up, middle and size
// and, unless imported with points, COLMAP's database.db, pairs.txt and logs/.
// kUnusableResult when the health verdict is "failed".
std::unique_ptr<pipeline::Stage> MakeSfmStage(const SfmStageOptions& options,
                                              uint64_t seed);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_SFM_SFM_STAGE_H_
