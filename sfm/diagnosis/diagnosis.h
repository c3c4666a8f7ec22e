// SPDX-License-Identifier: BSD-3-Clause
// Finds out why structure from motion failed, or what its result lacks, and
// says it in sentences that tell the user what to do. docs/sfm.md lists the
// rules and their limits.

#ifndef FREEGS_SFM_DIAGNOSIS_DIAGNOSIS_H_
#define FREEGS_SFM_DIAGNOSIS_DIAGNOSIS_H_

#include <vector>

#include "sfm/diagnosis/evidence.h"
#include "sfm/diagnosis/finding.h"
#include "sfm/scene/reconstruction.h"

namespace freegs::sfm {

// Applies all rules and returns what they find, the worst first. `models` is
// what was reconstructed, the best first; it may be empty.
//
//   const auto evidence = CollectEvidence(photos, database);
//   for (const Finding& finding : Diagnose(*evidence, models, {})) {
//     Show(finding.message, finding.advice);
//   }
std::vector<Finding> Diagnose(const SceneEvidence& evidence,
                              const std::vector<Reconstruction>& models,
                              const DiagnosisOptions& options);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_DIAGNOSIS_DIAGNOSIS_H_
