// SPDX-License-Identifier: BSD-3-Clause
// Measures answers to the truth's labels when there are no instances: every
// Gaussian answers for itself. (The paper's ablation without clustering is
// another thing: there, features are rendered and asked in the image.)

#ifndef FREEGS_STAGES_EVALUATION_GAUSSIAN_ANSWERS_H_
#define FREEGS_STAGES_EVALUATION_GAUSSIAN_ANSWERS_H_

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/status.h"
#include "stages/evaluation/evaluation_context.h"
#include "stages/evaluation/text_evaluation.h"

namespace freegs::stages {

struct GaussianTextQuality {
  std::optional<TextQuality> text;
  std::string model;                    // Name of the CLIP model.
  std::vector<std::string> cut_labels;  // As in LabelAnswers.
};

// Asks the workspace for each label of the truth and measures the answers. The
// answer to a label is all Gaussians whose relevancy to it is at least
// `min_relevancy` (semantics/queries/gaussian_relevancy.h), and the relevancy
// that is reported is the greatest of all Gaussians; no instance is.
// `clip_model` is the folder of the CLIP model; empty takes the one of the
// workspace's features. The errors are those of AnswerLabels and
// MeasureTextQuality.
StatusOr<GaussianTextQuality> MeasureGaussianText(
    const EvaluationContext& context,
    const std::filesystem::path& workspace,
    const std::string& clip_model,
    double min_relevancy);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_EVALUATION_GAUSSIAN_ANSWERS_H_
