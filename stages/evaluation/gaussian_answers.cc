// SPDX-License-Identifier: BSD-3-Clause

#include "stages/evaluation/gaussian_answers.h"

#include <algorithm>
#include <cstdint>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "semantics/clip/relevancy.h"
#include "semantics/field/idsf.h"
#include "semantics/losses/decoder_file.h"
#include "semantics/queries/gaussian_relevancy.h"
#include "stages/evaluation/label_answers.h"
#include "stages/scene/clip_input.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;

// The relevancy of each Gaussian to each label, N x L, as GaussianRelevancy
// returns it. Appends the labels that are too long for the model to
// `cut_labels`.
StatusOr<std::vector<float>> AskGaussians(
    const fs::path& workspace,
    const std::set<std::string>& labels,
    semantics::ClipEncoder& encoder,
    ThreadPool& pool,
    std::vector<std::string>* cut_labels) {
  const fs::path folder = workspace / "bootstrap";
  FREEGS_ASSIGN_OR_RETURN(const semantics::Idsf field,
                          semantics::ReadIdsf(folder / "idsf.bin"));
  FREEGS_ASSIGN_OR_RETURN(const semantics::StoredDecoder stored,
                          semantics::ReadDecoder(folder / "decoder.bin"));
  if (stored.decoder.feature_dim() != encoder.embedding_dim()) {
    return BadInputError((folder / "decoder.bin").string() +
                         " gives features of " +
                         std::to_string(stored.decoder.feature_dim()) +
                         " numbers, the CLIP model texts of " +
                         std::to_string(encoder.embedding_dim()) +
                         ": it is of another run; run stage bootstrap again");
  }
  FREEGS_ASSIGN_OR_RETURN(const std::vector<float> canonical,
                          semantics::EncodeCanonicalPhrases(encoder));
  std::vector<float> texts;
  for (const std::string& label : labels) {
    FREEGS_ASSIGN_OR_RETURN(const semantics::TextEmbedding text,
                            encoder.EncodeText(label));
    if (text.truncated) cut_labels->push_back(label);
    texts.insert(texts.end(), text.values.begin(), text.values.end());
  }
  return semantics::GaussianRelevancy(
      field, stored.decoder, texts, canonical, pool);
}

// The truth with the labels of all other objects removed.
GroundTruth OnlyLabel(const GroundTruth& truth, const std::string& label) {
  GroundTruth result = truth;
  for (TrueObject& object : result.objects) {
    if (object.label != label) object.label.clear();
  }
  return result;
}

}  // namespace

StatusOr<GaussianTextQuality> MeasureGaussianText(
    const EvaluationContext& context,
    const fs::path& workspace,
    const std::string& clip_model,
    double min_relevancy) {
  FREEGS_ASSIGN_OR_RETURN(const semantics::InstanceFeatures features,
                          ReadFeaturesOfInstances(workspace));
  FREEGS_ASSIGN_OR_RETURN(const std::unique_ptr<semantics::OpenCvClip> encoder,
                          OpenModelOfFeatures(features, workspace, clip_model));
  const std::set<std::string> labels = Labels(context.truth.objects);
  GaussianTextQuality result;
  FREEGS_ASSIGN_OR_RETURN(
      const std::vector<float> relevancy,
      AskGaussians(
          workspace, labels, *encoder, context.pool, &result.cut_labels));
  const size_t count = context.scene.model.size();
  if (relevancy.size() != count * labels.size()) {
    return BadInputError((workspace / "bootstrap" / "idsf.bin").string() +
                         " is not of this scene's Gaussians");
  }
  result.model = encoder->info().name;
  TextQuality quality;
  size_t column = 0;
  for (const std::string& label : labels) {
    std::vector<int32_t> chosen(count, -1);
    // The chosen Gaussians are measured as if they were the only instance.
    TextAnswer answer{.instance = 0, .relevancy = 0};
    for (size_t i = 0; i < count; ++i) {
      const double value = relevancy[i * labels.size() + column];
      answer.relevancy = std::max(answer.relevancy, value);
      if (value >= min_relevancy) chosen[i] = 0;
    }
    ++column;
    const GroundTruth only_label = OnlyLabel(context.truth, label);
    FREEGS_ASSIGN_OR_RETURN(
        std::optional<TextQuality> one,
        MeasureTextQuality({.scene = context.scene,
                            .truth = only_label,
                            .truth_from_scene = context.truth_from_scene,
                            .cancellation = context.cancellation,
                            .pool = context.pool},
                           chosen,
                           {{label, answer}}));
    if (!one) continue;
    for (LabelResult& of_label : one->labels) {
      of_label.answer.instance = -1;
      quality.labels.push_back(std::move(of_label));
    }
  }
  SummariseLabels(&quality);
  if (quality.miou || quality.boxes) result.text = std::move(quality);
  return result;
}

}  // namespace freegs::stages
