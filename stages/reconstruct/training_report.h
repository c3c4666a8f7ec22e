// SPDX-License-Identifier: BSD-3-Clause
// How the course of a training is told: in metrics.json and in log lines.

#ifndef FREEGS_STAGES_RECONSTRUCT_TRAINING_REPORT_H_
#define FREEGS_STAGES_RECONSTRUCT_TRAINING_REPORT_H_

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "splat/scene/gaussian_model.h"
#include "splat/train/trainer.h"
#include "splat/train/training_history.h"

namespace freegs::stages {

// The members "densification" (the option), "budget_search",
// "importance_metric", "milestones" and "recoveries" of metrics.json; null or
// empty without a trainer.
nlohmann::json CourseJson(const std::string& densification,
                          const splat::Trainer* trainer);

std::string RecoveryText(const splat::Recovery& recovery);
std::string MilestoneText(const splat::MilestoneRecord& record);

// A trial of the search for a budget, at 1 / 2^level of the image size.
std::string TrialText(const splat::GaussianModel& model,
                      double psnr,
                      int level);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_RECONSTRUCT_TRAINING_REPORT_H_
