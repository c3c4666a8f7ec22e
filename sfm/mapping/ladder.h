// SPDX-License-Identifier: BSD-3-Clause
// What is tried, in which order, when the plain way leaves photos out.

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
  std::vector<Reconstruction> models;  // Best first; may be empty.
  MatchedDatabase database;            // What they were made from.
  SceneEvidence evidence;              // Of that database.
  std::vector<Attempt> attempts;       // In the order in which they were made.
};

// Maps the database and, as long as the result is not good, climbs the rungs
// listed in ladder.cc: each is tried once, if what was seen so far says that it
// may help and the costs allow, and kept if it is better. Ends early when the
// diagnosis is that nothing helps.
//
// Errors of the first mapping, kInterrupted and kInternal are returned; a rung
// on which a command fails is only noted.
StatusOr<LadderResult> ClimbLadder(const StepContext& context,
                                   const MatchedDatabase& database,
                                   const DiagnosisOptions& diagnosis,
                                   AttemptStore* store);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_MAPPING_LADDER_H_
