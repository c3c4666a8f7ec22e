// SPDX-License-Identifier: BSD-3-Clause
// Asks a workspace which instance the words of a label mean.

#ifndef FREEGS_STAGES_EVALUATION_LABEL_ANSWERS_H_
#define FREEGS_STAGES_EVALUATION_LABEL_ANSWERS_H_

#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/status.h"
#include "semantics/queries/instance_features.h"
#include "stages/evaluation/text_evaluation.h"

namespace freegs::stages {

struct LabelQuestionOptions {
  // Folder of the CLIP model. Empty takes the model that the workspace's
  // instance features were made with; see OpenModelOfFeatures.
  std::string model;

  // Whether large planes (floor, walls, table tops) can be an answer.
  bool background = false;

  // An instance of smaller relevancy is no answer. Without this value the best
  // instance always answers, as in the paper.
  std::optional<double> min_relevancy;
};

struct LabelAnswers {
  std::map<std::string, TextAnswer> answers;  // One per label.
  std::string model;                          // Name of the CLIP model.

  // Labels too long for the model, which was asked only their beginning.
  std::vector<std::string> cut_labels;
};

// Reads bootstrap/instance_features.json. kMissingDependency when it is
// missing; kBadInput when it is malformed.
StatusOr<semantics::InstanceFeatures> ReadFeaturesOfInstances(
    const std::filesystem::path& workspace);

// Finds for each label the best instance of bootstrap/instance_features.json by
// semantics::QueryText. kMissingDependency when this file or the CLIP model is
// missing, or when the model's hash differs from the one in the file; kBadInput
// for malformed files.
StatusOr<LabelAnswers> AnswerLabels(const std::filesystem::path& workspace,
                                    const std::set<std::string>& labels,
                                    const LabelQuestionOptions& options);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_EVALUATION_LABEL_ANSWERS_H_
