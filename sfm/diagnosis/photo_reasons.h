// SPDX-License-Identifier: BSD-3-Clause
// Says about single photos whether they are blurred, and why they have no
// camera pose.

#ifndef FREEGS_SFM_DIAGNOSIS_PHOTO_REASONS_H_
#define FREEGS_SFM_DIAGNOSIS_PHOTO_REASONS_H_

#include <map>
#include <string>
#include <vector>

#include "sfm/diagnosis/evidence.h"
#include "sfm/diagnosis/finding.h"
#include "sfm/scene/reconstruction.h"

namespace freegs::sfm {

// For each photo of the evidence, whether it is much more blurred than the
// others. Such photos are not worth another attempt.
std::vector<bool> FindBlurredPhotos(const SceneEvidence& evidence);

// For each photo without a pose in models[0], by name, a sentence that tells
// what is known about the reason. `models`: the best first; may be empty.
std::map<std::string, std::string> ExplainUnregistered(
    const SceneEvidence& evidence,
    const std::vector<Reconstruction>& models,
    const DiagnosisOptions& options);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_DIAGNOSIS_PHOTO_REASONS_H_
