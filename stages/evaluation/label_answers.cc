// SPDX-License-Identifier: BSD-3-Clause

#include "stages/evaluation/label_answers.h"

#include <cstdint>
#include <memory>
#include <system_error>
#include <utility>
#include <vector>

#include "semantics/clip/opencv_clip.h"
#include "semantics/clip/relevancy.h"
#include "semantics/instances/instances_json.h"
#include "semantics/queries/text_query.h"
#include "stages/scene/clip_input.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;

// For each instance, by id - 1, whether it is a large plane.
StatusOr<std::vector<uint8_t>> PlaneFlags(const fs::path& workspace,
                                          size_t count) {
  FREEGS_ASSIGN_OR_RETURN(
      const std::vector<semantics::Instance> instances,
      semantics::ReadInstances(workspace / "bootstrap" / "instances.json"));
  std::vector<uint8_t> flags(count, 0);
  for (const semantics::Instance& instance : instances) {
    if (instance.id >= 1 && static_cast<size_t>(instance.id) <= count) {
      flags[instance.id - 1] = instance.background;
    }
  }
  return flags;
}

}  // namespace

StatusOr<semantics::InstanceFeatures> ReadFeaturesOfInstances(
    const fs::path& workspace) {
  const fs::path path = workspace / "bootstrap" / "instance_features.json";
  std::error_code error;
  if (!fs::exists(path, error)) {
    return MissingDependencyError(
        path.string() +
        " is not there; run stage bootstrap again with --bootstrap.mode lift "
        "to have the answers to words measured");
  }
  return semantics::ReadInstanceFeatures(path);
}

StatusOr<LabelAnswers> AnswerLabels(const fs::path& workspace,
                                    const std::set<std::string>& labels,
                                    const LabelQuestionOptions& options) {
  FREEGS_ASSIGN_OR_RETURN(const semantics::InstanceFeatures features,
                          ReadFeaturesOfInstances(workspace));
  FREEGS_ASSIGN_OR_RETURN(
      const std::unique_ptr<semantics::OpenCvClip> encoder,
      OpenModelOfFeatures(features, workspace, options.model));
  FREEGS_ASSIGN_OR_RETURN(const std::vector<uint8_t> planes,
                          PlaneFlags(workspace, features.size()));
  LabelAnswers result;
  result.model = encoder->info().name;
  FREEGS_ASSIGN_OR_RETURN(const std::vector<float> canonical,
                          semantics::EncodeCanonicalPhrases(*encoder));
  semantics::TextQueryOptions query;
  query.min_relevancy = 0;
  query.max_hits = 1;
  query.background = options.background;
  for (const std::string& label : labels) {
    FREEGS_ASSIGN_OR_RETURN(const semantics::TextEmbedding text,
                            encoder->EncodeText(label));
    if (text.truncated) result.cut_labels.push_back(label);
    FREEGS_ASSIGN_OR_RETURN(
        const std::vector<semantics::TextHit> hits,
        semantics::QueryText(features, text.values, canonical, query, planes));
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
