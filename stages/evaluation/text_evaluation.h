// SPDX-License-Identifier: BSD-3-Clause
// Compares what a scene answers to the truth's labels with the truth; the
// protocol is in docs/evaluation.md.

#ifndef FREEGS_STAGES_EVALUATION_TEXT_EVALUATION_H_
#define FREEGS_STAGES_EVALUATION_TEXT_EVALUATION_H_

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "core/status.h"
#include "stages/evaluation/evaluation_context.h"
#include "stages/evaluation/ground_truth.h"
#include "stages/evaluation/instance_evaluation.h"

namespace freegs::stages {

// The instance that a scene answers some words with.
struct TextAnswer {
  // Label as in idsf.bin; -1 when nothing answers, or no instance but Gaussians
  // (gaussian_answers.h).
  int instance = -1;
  // The relevancy of the best instance or Gaussian, even if it was refused.
  double relevancy = 0;
};

// The distinct labels of the objects.
std::set<std::string> Labels(const std::vector<TrueObject>& objects);

// A label and how well it was answered. Objects that share the label count as
// one: the answer is compared with the union of their masks, and with that box
// of theirs that fits best.
struct LabelResult {
  std::string label;
  int num_objects = 0;
  int num_views = 0;  // Test views in which it is judged.
  TextAnswer answer;

  // Means over the label's views: the IoU of masks, and the IoU of their
  // boundaries (semantics::BoundaryIou).
  std::optional<double> iou;
  std::optional<double> boundary_iou;

  // The IoU of boxes, axis-aligned in the truth's frame.
  std::optional<double> box_iou;
};

struct TextQuality {
  // Means over labels of their means over views, as in LERF-Mask.
  std::optional<double> miou;
  std::optional<double> mbiou;
  // Over the labels that have a box.
  std::optional<BoxQuality> boxes;
  std::vector<LabelResult> labels;
};

// Computes miou, mbiou and boxes from labels.
void SummariseLabels(TextQuality* quality);

// Compares the answers with the truth. `instance_of_gaussian` has one label per
// Gaussian of the scene, negative for none. `answers` are by label; a
// label of the truth without an answer counts as an empty mask. The result is
// empty when the truth has no labels, or neither masks of test views nor boxes
// for them. The errors are those of EvaluationContext::ForEachView.
StatusOr<std::optional<TextQuality>> MeasureTextQuality(
    const EvaluationContext& context,
    std::span<const int32_t> instance_of_gaussian,
    const std::map<std::string, TextAnswer>& answers);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_EVALUATION_TEXT_EVALUATION_H_
