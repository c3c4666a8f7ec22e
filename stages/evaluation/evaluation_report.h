// SPDX-License-Identifier: BSD-3-Clause
// The figures of an evaluation as JSON and as a table.

#ifndef FREEGS_STAGES_EVALUATION_EVALUATION_REPORT_H_
#define FREEGS_STAGES_EVALUATION_EVALUATION_REPORT_H_

#include <optional>
#include <ostream>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "sfm/scene/pose_alignment.h"
#include "stages/evaluation/consistency_evaluation.h"
#include "stages/evaluation/evaluation.h"
#include "stages/evaluation/instance_evaluation.h"
#include "stages/evaluation/text_evaluation.h"

namespace freegs::stages {

struct EvaluationReport {
  std::string workspace;
  std::string truth;  // Folder of the truth; empty without one.
  size_t num_gaussians = 0;
  size_t num_photos = 0;  // Photos that have a pose.
  std::optional<ImageQuality> holdout;
  std::optional<ImageQuality> test;
  std::optional<sfm::PoseAlignment> poses;
  size_t num_true_poses = 0;
  // The largest distance of a true training camera from the mean of all, in
  // units of the truth.
  double camera_extent = 0;
  std::optional<InstanceQuality> instances;
  // The mean IoU with the best level of the hierarchy for each object; see
  // level_evaluation.h.
  std::optional<double> best_level_miou;
  std::optional<ViewConsistency> consistency;
  std::optional<TextQuality> text;
  // Whether Gaussians answered to labels, each for itself, or else instances.
  bool text_from_gaussians = false;
  std::string text_model;  // Name of the CLIP model that was asked.
  // A label whose best relevancy is smaller has no answer; nothing when the
  // best instance always answers. Of Gaussians, those whose relevancy is
  // smaller do not answer.
  std::optional<double> text_threshold;
};

// The keys of docs/evaluation.md. A figure without truth is null. "psnr" and
// "ssim" are those of the test views, or of the holdout photographs when there
// are no test views; "psnr_views" says which.
nlohmann::json ToJson(const EvaluationReport& report);

// Prints the figures of ToJson for people.
void PrintTable(const EvaluationReport& report, std::ostream& out);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_EVALUATION_EVALUATION_REPORT_H_
