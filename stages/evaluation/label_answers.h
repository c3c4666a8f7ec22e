// SPDX-License-Identifier: BSD-3-Clause
// Asks a workspace for the instances that labels mean.

#ifndef FREEGS_STAGES_EVALUATION_LABEL_ANSWERS_H_
#define FREEGS_STAGES_EVALUATION_LABEL_ANSWERS_H_

#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>

#include "core/status.h"
#include "stages/evaluation/text_evaluation.h"

namespace freegs::stages {

struct LabelQuestionOptions {
  // Folder of the CLIP model; empty takes the one that the workspace's instance
  // features name, else, when they are of it, the one that comes with the
  // program.
  std::string model;

  // Whether large planes (floor, walls, table tops) may answer.
  bool background = false;

  // An instance of less relevancy is no answer. By default the best is always
  // one, as in the paper.
  std::optional<double> min_relevancy;
};

struct LabelAnswers {
  std::map<std::string, TextAnswer> answers;  // One per label.
  std::string model;                          // What it is called.
};

// The best instance of WORKSPACE/bootstrap/instance_features.json for each
// label (semantics::QueryText). kMissingDependency without these features,
// without the model, and for one of another hash than theirs; kBadInput for
// malformed files.
StatusOr<LabelAnswers> AnswerLabels(const std::filesystem::path& workspace,
                                    const std::set<std::string>& labels,
                                    const LabelQuestionOptions& options);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_EVALUATION_LABEL_ANSWERS_H_
