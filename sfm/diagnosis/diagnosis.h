// SPDX-License-Identifier: BSD-3-Clause
// Why structure from motion failed, or how far its result can be trusted, in
// words that tell what to do about it.

#ifndef FREEGS_SFM_DIAGNOSIS_DIAGNOSIS_H_
#define FREEGS_SFM_DIAGNOSIS_DIAGNOSIS_H_

#include <vector>

#include "sfm/diagnosis/evidence.h"
#include "sfm/diagnosis/finding.h"
#include "sfm/scene/reconstruction.h"

namespace freegs::sfm {

// The findings, worst first. models: what was reconstructed, the best first.
std::vector<Finding> Diagnose(const SceneEvidence& evidence,
                              const std::vector<Reconstruction>& models,
                              const DiagnosisOptions& options);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_DIAGNOSIS_DIAGNOSIS_H_
