// SPDX-License-Identifier: BSD-3-Clause

#include "stages/label_answers.h"

#include <memory>
#include <system_error>
#include <utility>
#include <vector>

#include "semantics/clip/opencv_clip.h"
#include "semantics/clip/relevancy.h"
#include "semantics/instance_features.h"
#include "semantics/text_query.h"
#include "stages/shipped_model.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;

// Where the model of the features is, relative to the workspace or not; the one
// that comes with the program when it is not there. Whether it is the same is
// seen by its hash.
StatusOr<fs::path> FindModel(const fs::path& workspace,
                             const std::string& model) {
  std::error_code error;
  const fs::path folder = workspace / model;
  if (!model.empty() && fs::exists(folder / "model.json", error)) return folder;
  return FindShippedModel();
}

}  // namespace

StatusOr<LabelAnswers> AnswerLabels(const fs::path& workspace,
                                    const std::set<std::string>& labels,
                                    const LabelQuestionOptions& options) {
  const fs::path path = workspace / "bootstrap" / "instance_features.json";
  std::error_code error;
  if (!fs::exists(path, error)) {
    return MissingDependencyError(
        path.string() +
        " is not there; run stage bootstrap with a CLIP model to have the "
        "answers to words measured");
  }
  FREEGS_ASSIGN_OR_RETURN(const semantics::InstanceFeatures features,
                          semantics::ReadInstanceFeatures(path));
  LabelAnswers result;
  result.model = options.model;
  if (result.model.empty()) {
    FREEGS_ASSIGN_OR_RETURN(result.model, FindModel(workspace, features.model));
  }
  FREEGS_ASSIGN_OR_RETURN(const std::unique_ptr<semantics::OpenCvClip> encoder,
                          semantics::OpenCvClip::Open(result.model));
  if (encoder->model_hash() != features.model_hash) {
    return BadInputError(path.string() +
                         ": its features are of another model (" +
                         features.model + ") than that in " +
                         result.model.string() + "; name theirs with --model");
  }
  FREEGS_ASSIGN_OR_RETURN(const std::vector<float> canonical,
                          semantics::EncodeCanonicalPhrases(*encoder));
  semantics::TextQueryOptions query;
  query.min_relevancy = 0;
  query.max_hits = 1;
  query.background = true;
  for (const std::string& label : labels) {
    FREEGS_ASSIGN_OR_RETURN(const semantics::TextEmbedding text,
                            encoder->EncodeText(label));
    FREEGS_ASSIGN_OR_RETURN(
        const std::vector<semantics::TextHit> hits,
        semantics::QueryText(features, text.values, canonical, query));
    TextAnswer& answer = result.answers[label];
    if (hits.empty()) continue;
    answer.relevancy = hits[0].relevancy;
    if (!options.min_relevancy || answer.relevancy >= *options.min_relevancy) {
      answer.instance = hits[0].id - 1;
    }
  }
  return result;
}

}  // namespace freegs::stages
