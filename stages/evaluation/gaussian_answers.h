// SPDX-License-Identifier: BSD-3-Clause
// The figures of text when every Gaussian answers for itself.

#ifndef FREEGS_STAGES_EVALUATION_GAUSSIAN_ANSWERS_H_
#define FREEGS_STAGES_EVALUATION_GAUSSIAN_ANSWERS_H_

#include <filesystem>
#include <optional>
#include <string>

#include "core/cancellation.h"
#include "core/parallel.h"
#include "core/status.h"
#include "stages/evaluation/ground_truth.h"
#include "stages/evaluation/text_evaluation.h"
#include "stages/scene/workspace_scene.h"

namespace freegs::stages {

struct GaussianTextQuality {
  std::optional<TextQuality> text;
  std::string model;  // What the CLIP model is called.
};

// As AnswerLabels() and MeasureTextQuality() in one, but a label's answer is
// all Gaussians that it is relevant to, by at least min_relevancy; see
// semantics/queries/gaussian_relevancy.h. A label's relevancy is its greatest.
// Errors as theirs.
StatusOr<GaussianTextQuality> MeasureGaussianText(
    const std::filesystem::path& workspace,
    const std::string& clip_model,
    double min_relevancy,
    const WorkspaceScene& scene,
    const GroundTruth& truth,
    const Sim3d& truth_from_scene,
    const CancellationToken& cancellation,
    ThreadPool& pool);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_EVALUATION_GAUSSIAN_ANSWERS_H_
