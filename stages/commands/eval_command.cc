// SPDX-License-Identifier: BSD-3-Clause

#include "stages/commands/eval_command.h"

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/io/files.h"
#include "core/io/json_text.h"
#include "core/parallel.h"
#include "pipeline/system_info.h"
#include "stages/datasets/layout.h"
#include "stages/evaluation/consistency_evaluation.h"
#include "stages/evaluation/evaluation.h"
#include "stages/evaluation/evaluation_context.h"
#include "stages/evaluation/evaluation_report.h"
#include "stages/evaluation/gaussian_answers.h"
#include "stages/evaluation/instance_evaluation.h"
#include "stages/evaluation/label_answers.h"
#include "stages/evaluation/level_evaluation.h"
#include "stages/evaluation/text_evaluation.h"
#include "stages/registry/pipeline_options.h"
#include "stages/scene/scene_alignment.h"
#include "stages/scene/scene_instances.h"
#include "stages/scene/training_scene.h"
#include "stages/scene/workspace_scene.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;

double CameraExtent(const std::vector<View>& views) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const View& view : views) mean += CameraCentre(view.cam_from_world);
  mean /= static_cast<double>(std::max<size_t>(1, views.size()));
  double extent = 0;
  for (const View& view : views) {
    extent =
        std::max(extent, (CameraCentre(view.cam_from_world) - mean).norm());
  }
  return extent;
}

struct EvalRequest {
  fs::path workspace;
  std::string truth;
  std::string layout = "auto";
  std::string model;
  std::string text_from = "instances";
  double text_threshold = 0;
  std::string json_file;
  PipelineOptions options;
};

CommandWords DescribeEval(EvalRequest* request) {
  pipeline::OptionTable table = MakeOptionTable(&request->options);
  table.LimitCommandLine({"general.threads", "query.background"});
  CommandWords words("eval",
                     "Measures a scene: on its holdout photographs, and "
                     "against ground truth where there is one.",
                     std::move(table));
  std::vector<std::string> layouts = LayoutNames();
  layouts.insert(layouts.begin(), "auto");
  words.AddArgument(WorkspaceArgument());
  words.AddOption("gt",
                  &request->truth,
                  {.help = "Folder with the truth: gt/cameras.json, "
                           "gt/objects.json, gt/instance/, test/images/; or a "
                           "scene of a public data set.",
                   .value_name = "DIR"});
  words.AddOption(
      "layout",
      &request->layout,
      {.help = "Layout of the truth; auto looks what lies in its folder.",
       .choices = layouts});
  words.AddOption("model",
                  &request->model,
                  {.help = "Folder of the CLIP model that the truth's labels "
                           "are asked with; the workspace's own when not "
                           "given.",
                   .value_name = "DIR"});
  words.AddOption("text-from",
                  &request->text_from,
                  {.help = "Who answers to labels: the best of all instances, "
                           "or all Gaussians that a label is relevant to, each "
                           "for itself, as if there were no instances.",
                   .choices = {"instances", "gaussians"}});
  words.AddOption("text-threshold",
                  &request->text_threshold,
                  {.help = "Relevancy below which a label has no answer; 0 "
                           "takes the best instance whatever its relevancy, "
                           "and Gaussians of 0.5 and more.",
                   .min = 0,
                   .max = 1});
  words.AddOption(
      "json",
      &request->json_file,
      {.help = "File to write the figures to; - is standard output.",
       .value_name = "FILE"});
  return words;
}

StatusOr<EvalRequest> ParseEvalRequest(
    const std::vector<std::string>& arguments) {
  EvalRequest request;
  CommandWords words = DescribeEval(&request);
  FREEGS_ASSIGN_OR_RETURN(const pipeline::OptionTable::CommandLine line,
                          words.Parse(arguments));
  FREEGS_ASSIGN_OR_RETURN(request.workspace,
                          ExistingWorkspace(line.positional[0]));
  FREEGS_RETURN_IF_ERROR(
      ApplyQuerySettings(request.workspace, line.settings, words.table()));
  if (!request.json_file.empty() && request.json_file != "-") {
    FREEGS_RETURN_IF_ERROR(
        CheckOutputPlace(request.workspace, request.json_file));
    const StatusOr<fs::path> file = PrepareOutputFile(request.json_file);
    if (!file.ok()) {
      return BadInputError(file.status().message() +
                           ", or - for standard output");
    }
    request.json_file = file->string();
  }
  return request;
}

// The truth, and the similarity from the scene's frame to the truth's.
struct AlignedTruth {
  GroundTruth truth;
  Sim3d truth_from_scene;
};

StatusOr<AlignedTruth> ReadAlignedTruth(const EvalRequest& request,
                                        const WorkspaceScene& scene,
                                        CommandContext& context,
                                        EvaluationReport* report) {
  AlignedTruth aligned;
  FREEGS_ASSIGN_OR_RETURN(aligned.truth,
                          ReadTruth(request.truth, request.layout));
  GroundTruth& truth = aligned.truth;
  report->truth = truth.folder.string();
  if (truth.unposed.empty()) {
    FREEGS_ASSIGN_OR_RETURN(
        report->poses,
        AlignWithViews(scene, truth.cameras.train, truth.folder.string()));
    report->num_true_poses = truth.cameras.train.size();
    report->camera_extent = CameraExtent(truth.cameras.train);
    aligned.truth_from_scene = report->poses->target_from_source;
    // What is reported is about the world of the workspace's files.
    report->poses->target_from_source =
        aligned.truth_from_scene * scene.frame.FrameFromWorld();
  } else {
    FREEGS_ASSIGN_OR_RETURN(
        const std::vector<std::string> missing,
        TakeWorkspaceCameras(request.workspace, scene, &truth));
    for (const std::string& name : missing) {
      context.err << "eval: " << name
                  << ": a test view that the workspace has no pose for; it is "
                     "left out\n";
    }
  }
  for (const std::string& name : TrainedOn(scene, truth)) {
    context.err << "eval: " << name
                << ": a test view that the scene was trained on; hold it out "
                   "with ingest.holdout_list to measure on what is new\n";
  }
  return aligned;
}

// The label of each Gaussian. Returns nothing, after a message, when the
// workspace has no instances.
StatusOr<std::optional<std::vector<int32_t>>> ReadInstances(
    const fs::path& workspace,
    const WorkspaceScene& scene,
    CommandContext& context) {
  const fs::path field = workspace / "bootstrap" / "idsf.bin";
  std::error_code error;
  if (!fs::exists(field, error)) {
    context.err << "eval: " << field.string()
                << " is not there; run stage bootstrap to have instances "
                   "measured\n";
    return std::optional<std::vector<int32_t>>();
  }
  FREEGS_ASSIGN_OR_RETURN(std::vector<int32_t> labels,
                          ReadInstanceLabels(workspace, scene.model.size()));
  return std::optional(std::move(labels));
}

// A workspace that cannot answer words has no figures of text, and a message
// says why. But a user who names a model wants its figures, so a fault is an
// error then.
Status NoFiguresOfText(const Status& why,
                       const EvalRequest& request,
                       CommandContext& context) {
  if (why.code() != StatusCode::kMissingDependency || !request.model.empty()) {
    return why;
  }
  context.err << "eval: no figures of text: " << why.message() << "\n";
  return Status();
}

void TellCutLabels(const std::vector<std::string>& labels,
                   CommandContext& context) {
  for (const std::string& label : labels) {
    context.err << "eval: label \"" << label
                << "\" is too long for the model; it sees only its beginning\n";
  }
}

Status MeasureTextOfGaussians(const EvalRequest& request,
                              const EvaluationContext& evaluation,
                              CommandContext& context,
                              EvaluationReport* report) {
  if (Labels(evaluation.truth.objects).empty()) return Status();
  const double threshold =
      request.text_threshold > 0 ? request.text_threshold : 0.5;
  StatusOr<GaussianTextQuality> found = MeasureGaussianText(
      evaluation, request.workspace, request.model, threshold);
  if (!found.ok()) return NoFiguresOfText(found.status(), request, context);
  TellCutLabels(found->cut_labels, context);
  report->text_from_gaussians = true;
  report->text_threshold = threshold;
  report->text_model = std::move(found->model);
  report->text = std::move(found->text);
  return Status();
}

Status MeasureText(const EvalRequest& request,
                   const EvaluationContext& evaluation,
                   const std::vector<int32_t>& instances,
                   CommandContext& context,
                   EvaluationReport* report) {
  const std::set<std::string> labels = Labels(evaluation.truth.objects);
  if (labels.empty()) return Status();
  LabelQuestionOptions questions;
  questions.model = request.model;
  // 3D-OVS also asks for table tops and walls.
  const std::optional<std::string> layout =
      request.layout == "auto" ? DetectLayout(request.truth) : request.layout;
  questions.background = request.options.query.background || layout == "3dovs";
  if (request.text_threshold > 0) {
    questions.min_relevancy = request.text_threshold;
  }
  const StatusOr<LabelAnswers> answers =
      AnswerLabels(request.workspace, labels, questions);
  if (!answers.ok()) return NoFiguresOfText(answers.status(), request, context);
  TellCutLabels(answers->cut_labels, context);
  report->text_model = answers->model;
  report->text_threshold = questions.min_relevancy;
  FREEGS_ASSIGN_OR_RETURN(
      report->text,
      MeasureTextQuality(evaluation, instances, answers->answers));
  return Status();
}

Status CompareWithTruth(const EvalRequest& request,
                        const WorkspaceScene& scene,
                        const std::optional<std::vector<int32_t>>& instances,
                        CommandContext& context,
                        ThreadPool& pool,
                        EvaluationReport* report) {
  FREEGS_ASSIGN_OR_RETURN(const AlignedTruth aligned,
                          ReadAlignedTruth(request, scene, context, report));
  const EvaluationContext evaluation{
      .scene = scene,
      .truth = aligned.truth,
      .truth_from_scene = aligned.truth_from_scene,
      .cancellation = context.cancellation,
      .pool = pool};
  FREEGS_ASSIGN_OR_RETURN(report->test, MeasureTestQuality(evaluation));
  if (!instances) return Status();
  FREEGS_ASSIGN_OR_RETURN(report->instances,
                          MeasureInstanceQuality(evaluation, *instances));
  std::error_code error;
  if (fs::exists(request.workspace / "bootstrap" / "hierarchy.json", error)) {
    FREEGS_ASSIGN_OR_RETURN(
        const semantics::Hierarchy hierarchy,
        ReadSceneHierarchy(request.workspace, scene.model.size()));
    FREEGS_ASSIGN_OR_RETURN(
        report->best_level_miou,
        MeasureBestLevels(evaluation, *instances, hierarchy));
  }
  if (request.text_from == "gaussians") {
    return MeasureTextOfGaussians(request, evaluation, context, report);
  }
  return MeasureText(request, evaluation, *instances, context, report);
}

}  // namespace

CommandWords EvalWords() { return KeepWords<EvalRequest>(DescribeEval); }

Status RunEvalCommand(const std::vector<std::string>& arguments,
                      CommandContext& context) {
  FREEGS_ASSIGN_OR_RETURN(const EvalRequest request,
                          ParseEvalRequest(arguments));
  WarnOfRun(request.workspace, context);
  ThreadPool pool(pipeline::WorkingThreads(request.options.general.threads));
  FREEGS_ASSIGN_OR_RETURN(const WorkspaceScene scene,
                          ReadWorkspaceScene(request.workspace));
  EvaluationReport report;
  report.workspace = request.workspace.string();
  report.num_gaussians = scene.model.size();
  report.num_photos = scene.train.size() + scene.holdout.size();
  FREEGS_ASSIGN_OR_RETURN(
      report.holdout,
      MeasureHoldoutQuality(scene,
                            request.workspace / "undistort" / "images",
                            TrainingMaskFolder(request.workspace),
                            context.cancellation,
                            pool));
  FREEGS_ASSIGN_OR_RETURN(const auto instances,
                          ReadInstances(request.workspace, scene, context));
  if (instances) {
    FREEGS_ASSIGN_OR_RETURN(
        report.consistency,
        MeasureViewConsistency(scene, *instances, context.cancellation, pool));
  }
  if (!request.truth.empty()) {
    FREEGS_RETURN_IF_ERROR(
        CompareWithTruth(request, scene, instances, context, pool, &report));
  }
  if (request.json_file == "-") {
    context.out << JsonText(ToJson(report));
    return Status();
  }
  PrintTable(report, context.out);
  if (request.json_file.empty()) return Status();
  return WriteFileAtomic(request.json_file, JsonText(ToJson(report)));
}

}  // namespace freegs::stages
