// SPDX-License-Identifier: BSD-3-Clause
// Reads 3D-OVS (Liu et al., "Weakly Supervised 3D Open-vocabulary
// Segmentation", 2023), which has masks of classes in test views.

#ifndef FREEGS_STAGES_DATASETS_THREE_D_OVS_H_
#define FREEGS_STAGES_DATASETS_THREE_D_OVS_H_

#include <filesystem>

#include "core/status.h"
#include "stages/evaluation/ground_truth.h"

namespace freegs::stages {

// Reads a scene as its authors release it, with or without the COLMAP model
// that others add:
//   images/NAME.jpg
//   segmentations/classes.txt            one class per line
//   segmentations/NAME/CLASS.png         where the class is, white on black
//   sparse/0/                            optional
// NAME may have other leading zeros than the photograph's name. CLASS is a line
// of classes.txt, in upper or lower case and with '_' for blanks; a mask with
// another name is a class of its own. Without the model, the test views are
// `unposed`; poses_bounds.npy of the release is not read. kBadInput says what
// is missing or does not fit together.
StatusOr<GroundTruth> ReadThreeDOvs(const std::filesystem::path& scene);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_DATASETS_THREE_D_OVS_H_
