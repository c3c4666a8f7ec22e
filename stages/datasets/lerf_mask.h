// SPDX-License-Identifier: BSD-3-Clause
// LERF-Mask (Ye et al., "Gaussian Grouping", 2024): masks of phrases in test
// views of scenes of LERF (Kerr et al. 2023).

#ifndef FREEGS_STAGES_DATASETS_LERF_MASK_H_
#define FREEGS_STAGES_DATASETS_LERF_MASK_H_

#include <filesystem>

#include "core/status.h"
#include "stages/evaluation/ground_truth.h"

namespace freegs::stages {

// Reads a scene as its authors release it:
//   sparse/0/                      COLMAP model of all photographs
//   images/, images_train/         all photographs; those to train on
//   test_mask/VIEW/PHRASE.png      where the phrase is, white on black
// VIEW is k for the k-th (from 0) of the photographs that are not in
// images_train, by name, or the name of a photograph without its suffix.
// Phrases may overlap, and not every view has all. kBadInput says what is
// missing or does not fit together.
StatusOr<GroundTruth> ReadLerfMask(const std::filesystem::path& scene);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_DATASETS_LERF_MASK_H_
