// SPDX-License-Identifier: BSD-3-Clause
// Describes the course of a training, for metrics.json and for log lines.

#ifndef FREEGS_STAGES_RECONSTRUCT_TRAINING_REPORT_H_
#define FREEGS_STAGES_RECONSTRUCT_TRAINING_REPORT_H_

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "splat/train/exposure_choice.h"
#include "splat/train/trainer.h"
#include "splat/train/training_history.h"

namespace freegs::stages {

// The members "densification" (the option's value), "budget",
// "exposure_search", "importance_metric", "milestones" and "recoveries" of
// metrics.json. They are null or empty when `trainer` is null, as for an
// imported model.
nlohmann::json CourseJson(const std::string& densification,
                          const splat::Trainer* trainer);

// One line each, without the stage's name.
std::string RecoveryText(const splat::Recovery& recovery);
std::string MilestoneText(const splat::MilestoneRecord& record);

// Says whether the exposure of each photo is learnt, and why. Without a choice
// it says that there was no time for one.
std::string ExposureText(const std::optional<splat::ExposureChoice>& choice);

// A holdout view: by how many pixels the photo lies beside the rendering, and
// the longest side of both.
struct DisplacedView {
  double pixels = 0;
  int longest_side = 0;
};

// A warning, without the stage's name, when more than half of the holdout
// photos lie far beside what the scene shows from their poses; empty otherwise.
// `imported_scene`: it was not trained with these poses (reconstruct.import).
std::string DisplacementNote(const std::vector<DisplacedView>& views,
                             bool imported_scene);

// A warning, without the stage's name, when the PSNR of holdout photos is far
// below that of photos that were trained on, both in dB; empty otherwise, and
// without holdout photos.
std::string NewViewsNote(double trained_psnr,
                         const std::vector<double>& holdout_psnr);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_RECONSTRUCT_TRAINING_REPORT_H_
