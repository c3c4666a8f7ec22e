// SPDX-License-Identifier: BSD-3-Clause
// The figures of an evaluation, for programs and for people.

#ifndef FREEGS_STAGES_EVALUATION_EVALUATION_REPORT_H_
#define FREEGS_STAGES_EVALUATION_EVALUATION_REPORT_H_

#include <optional>
#include <ostream>
#include <string>

#include <nlohmann/json.hpp>

#include "sfm/scene/pose_alignment.h"
#include "stages/evaluation/consistency_evaluation.h"
#include "stages/evaluation/evaluation.h"
#include "stages/evaluation/instance_evaluation.h"
#include "stages/evaluation/text_evaluation.h"

namespace freegs::stages {

struct EvaluationReport {
  std::string workspace;
  std::string truth;  // Empty without one.
  size_t num_gaussians = 0;
  size_t num_photos = 0;  // With a pose.
  std::optional<ImageQuality> holdout;
  std::optional<ImageQuality> test;
  std::optional<sfm::PoseAlignment> poses;
  size_t num_true_poses = 0;
  // Largest distance of a true training camera from their mean, truth's units.
  double camera_extent = 0;
  std::optional<InstanceQuality> instances;
  std::optional<ViewConsistency> consistency;
  std::optional<TextQuality> text;
  std::string text_model;                // The CLIP model that was asked.
  std::optional<double> text_threshold;  // Relevancy below which nothing is
                                         // answered, if one was asked for.
};

// The keys of docs/evaluation.md (psnr, ssim, pose_rotation_deg, ...), each
// null where there is no truth for it, and the details. "psnr" and "ssim" are
// of the test views, or of the holdout photographs when there are none;
// "psnr_views" says which.
nlohmann::json ToJson(const EvaluationReport& report);

void PrintTable(const EvaluationReport& report, std::ostream& out);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_EVALUATION_EVALUATION_REPORT_H_
