// SPDX-License-Identifier: BSD-3-Clause
// The ladder: other ways of matching and mapping the photos, which are tried
// one after the other when the plain way leaves photos without a pose.

#ifndef FREEGS_SFM_MAPPING_LADDER_H_
#define FREEGS_SFM_MAPPING_LADDER_H_

#include <filesystem>
#include <string>
#include <vector>

#include "core/status.h"
#include "sfm/colmap/colmap_steps.h"
#include "sfm/diagnosis/diagnosis.h"
#include "sfm/diagnosis/evidence.h"
#include "sfm/mapping/attempt.h"

namespace freegs::sfm {

struct LadderResult {
  std::vector<Reconstruction> models;  // The best first; may be empty.
  MatchedDatabase database;            // The database they were made from.
  SceneEvidence evidence;              // What that database tells.
  std::vector<Attempt> attempts;       // In the order in which they were made.
};

// Maps the database in the plain way. As long as too few photos have a pose, it
// then tries the rungs that ladder.cc lists, in that order and each at most
// once. A rung is tried if the photos left out are such that it may help, and
// if options.max_retry_cost allows; its result is kept if it is better than the
// one before. No more rungs are tried when a finding says that nothing helps.
//
//   AttemptStore store(work_folder, &record);
//   const StatusOr<LadderResult> best =
//       ClimbLadder(context, {database, record.pairs(), image_size}, {},
//       &store);
//
// Errors: those of the plain mapping, kInterrupted and kInternal. Another error
// of a rung is written into its Attempt, and the next rung is tried.
StatusOr<LadderResult> ClimbLadder(const StepContext& context,
                                   const MatchedDatabase& database,
                                   const DiagnosisOptions& diagnosis,
                                   AttemptStore* store);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_MAPPING_LADDER_H_
