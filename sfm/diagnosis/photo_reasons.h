// SPDX-License-Identifier: BSD-3-Clause
// What is known about single photos: which are blurred, and why some have no
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

// For each photo whether it is much more blurred than the others. Such photos
// are not worth another attempt.
std::vector<bool> FindBlurredPhotos(const SceneEvidence& evidence,
                                    const DiagnosisOptions& options);

// For each photo that the best model lacks: why, as far as is known.
std::map<std::string, std::string> ExplainUnregistered(
    const SceneEvidence& evidence,
    const std::vector<Reconstruction>& models,
    const DiagnosisOptions& options);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_DIAGNOSIS_PHOTO_REASONS_H_
