// SPDX-License-Identifier: BSD-3-Clause
// Reads LERF-Mask (Ye et al., "Gaussian Grouping", 2024), which has masks of
// phrases in test views of scenes of LERF (Kerr et al. 2023).

#ifndef FREEGS_STAGES_DATASETS_LERF_MASK_H_
#define FREEGS_STAGES_DATASETS_LERF_MASK_H_

#include <filesystem>

#include "core/status.h"
#include "stages/evaluation/ground_truth.h"

namespace freegs::stages {

// Reads a scene as its authors release it:
//   sparse/0/                   COLMAP model of all photographs
//   images/                     all photographs
//   images_train/               the photographs to train on
//   test_mask/VIEW/PHRASE.png   where the phrase is, white on black
// VIEW is the name of a photograph without its suffix, or a number k: the k-th
// photograph, from 0 and by name, of those that are not in images_train.
// Phrases may overlap, and not every view has all of them. kBadInput says what
// is missing or does not fit together.
StatusOr<GroundTruth> ReadLerfMask(const std::filesystem::path& scene);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_DATASETS_LERF_MASK_H_
