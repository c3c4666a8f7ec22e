// SPDX-License-Identifier: BSD-3-Clause
// Measures the picture quality of a workspace's scene; the protocol is in
// docs/evaluation.md. The command `eval` (stages/commands/eval_command.cc) does
//
//   ReadTruth(folder, "auto")                     the truth, datasets/layout.h
//   AlignWithViews(scene, truth.cameras.train,    its frame,
//                  name)                          scene/scene_alignment.h
//   MeasureHoldoutQuality(...)
//   EvaluationContext context{...}                evaluation_context.h
//   MeasureTestQuality(context)
//   MeasureInstanceQuality(context, ...)          instance_evaluation.h
//   MeasureBestLevels(context, ...)               level_evaluation.h
//   AnswerLabels(...)                             label_answers.h
//   MeasureTextQuality(context, ...)              text_evaluation.h
//   MeasureViewConsistency(...)                   consistency_evaluation.h
//   ToJson(report), PrintTable(report, out)       evaluation_report.h

#ifndef FREEGS_STAGES_EVALUATION_EVALUATION_H_
#define FREEGS_STAGES_EVALUATION_EVALUATION_H_

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/cancellation.h"
#include "core/parallel.h"
#include "core/status.h"
#include "stages/evaluation/evaluation_context.h"
#include "stages/evaluation/ground_truth.h"
#include "stages/scene/workspace_scene.h"

namespace freegs::stages {

// What a workspace did with the photograph of a test view.
enum class TestViewUse {
  kNone,      // It was never given, or has no pose.
  kTraining,  // The scene was trained on it.
  kHoldout,   // It got its pose with the others, but was not trained on.
};

// Returns the use of each of truth.cameras.test. Photographs and views belong
// together by their names, as sfm::MatchNames compares them. A photograph that
// may as well be that of a training view of the truth counts for none.
std::vector<TestViewUse> FindTestViewUses(const WorkspaceScene& scene,
                                          const GroundTruth& truth);

// The picture quality of a set of views; psnr and ssim are means over them.
struct ImageQuality {
  struct ViewQuality {
    std::string name;
    double psnr = 0;  // dB.
    double ssim = 0;
    TestViewUse use = TestViewUse::kNone;
  };
  double psnr = 0;  // dB.
  double ssim = 0;
  std::vector<ViewQuality> views;

  size_t Count(TestViewUse use) const;
};

// Renders the holdout views at the size of training and compares them with
// their photographs in photos_folder, where their masks in mask_folder (empty:
// none) do not say to ignore them. The result is empty without holdout views,
// and if masks leave nothing of any. kInterrupted when cancelled.
StatusOr<std::optional<ImageQuality>> MeasureHoldoutQuality(
    const WorkspaceScene& scene,
    const std::filesystem::path& photos_folder,
    const std::filesystem::path& mask_folder,
    const CancellationToken& cancellation,
    ThreadPool& pool);

// Renders the truth's test views at their full size and compares them with the
// truth's photographs. The result is empty when the truth has none. kBadInput
// names a photograph that has another size than its view. kInterrupted when
// cancelled.
StatusOr<std::optional<ImageQuality>> MeasureTestQuality(
    const EvaluationContext& context);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_EVALUATION_EVALUATION_H_
