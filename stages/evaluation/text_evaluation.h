// SPDX-License-Identifier: BSD-3-Clause
// What a scene answers to the truth's labels, against the truth; the protocol
// is in docs/evaluation.md.

#ifndef FREEGS_STAGES_EVALUATION_TEXT_EVALUATION_H_
#define FREEGS_STAGES_EVALUATION_TEXT_EVALUATION_H_

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "core/cancellation.h"
#include "core/parallel.h"
#include "core/status.h"
#include "stages/evaluation/ground_truth.h"
#include "stages/evaluation/instance_evaluation.h"
#include "stages/scene/workspace_scene.h"

namespace freegs::stages {

// The instance that a scene gives for some words.
struct TextAnswer {
  int instance = -1;     // As in idsf.bin; -1 for none.
  double relevancy = 0;  // Of the instance, or of the best one refused.
};

// The distinct labels of the truth's objects, in order.
std::set<std::string> Labels(const std::vector<TrueObject>& objects);

// A label and what became of it. Objects that share it are one: the union of
// their masks, and whichever of their boxes fits best.
struct LabelResult {
  std::string label;
  int num_objects = 0;
  int num_views = 0;  // Test views in which it is judged.
  TextAnswer answer;

  // Means over its views, of masks and of their boundaries (BoundaryIou).
  std::optional<double> iou;
  std::optional<double> boundary_iou;

  // Axis-aligned, in the truth's frame.
  std::optional<double> box_iou;
};

struct TextQuality {
  // Means over labels of their means over views (as on LERF-Mask).
  std::optional<double> miou;
  std::optional<double> mbiou;
  // Over the labels that have a box.
  std::optional<BoxQuality> boxes;
  std::vector<LabelResult> labels;
};

// The means, from labels.
void SummariseLabels(TextQuality* quality);

// answers: one for each of Labels(truth.objects); a missing one is none, and
// its mask empty. Nothing when the truth has no labels, or neither masks of
// test views nor boxes for them. Errors as ForEachJudgedView.
StatusOr<std::optional<TextQuality>> MeasureTextQuality(
    const WorkspaceScene& scene,
    std::span<const int32_t> instance_of_gaussian,
    const std::map<std::string, TextAnswer>& answers,
    const GroundTruth& truth,
    const Sim3d& truth_from_scene,
    const EvaluationOptions& options,
    const CancellationToken& cancellation,
    ThreadPool& pool);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_EVALUATION_TEXT_EVALUATION_H_
