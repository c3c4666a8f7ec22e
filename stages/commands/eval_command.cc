// SPDX-License-Identifier: BSD-3-Clause

#include "stages/commands/eval_command.h"

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

#include "core/files.h"
#include "core/parallel.h"
#include "pipeline/json_text.h"
#include "semantics/idsf.h"
#include "stages/evaluation.h"
#include "stages/evaluation_report.h"
#include "stages/ground_truth.h"
#include "stages/pipeline_options.h"
#include "stages/workspace_scene.h"

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

Status CompareWithTruth(const fs::path& folder,
                        const fs::path& workspace,
                        const WorkspaceScene& scene,
                        CommandContext& context,
                        ThreadPool& pool,
                        EvaluationReport* report) {
  FREEGS_ASSIGN_OR_RETURN(const GroundTruth truth, ReadGroundTruth(folder));
  FREEGS_ASSIGN_OR_RETURN(report->poses, AlignWithTruth(scene, truth));
  report->truth = truth.folder.string();
  report->num_true_poses = truth.cameras.train.size();
  report->camera_extent = CameraExtent(truth.cameras.train);
  const Sim3d truth_from_scene = report->poses->target_from_source;
  FREEGS_ASSIGN_OR_RETURN(
      report->test,
      MeasureTestQuality(
          scene, truth, truth_from_scene, context.cancellation, pool));
  const fs::path field = workspace / "bootstrap" / "idsf.bin";
  std::error_code error;
  if (!fs::exists(field, error)) {
    context.err << "eval: " << field.string()
                << " is not there; run stage bootstrap to have instances "
                   "measured\n";
    return Status();
  }
  FREEGS_ASSIGN_OR_RETURN(const semantics::Idsf idsf,
                          semantics::ReadIdsf(field));
  if (idsf.instances.size() != scene.model.size()) {
    return BadInputError(
        field.string() + ": holds " + std::to_string(idsf.instances.size()) +
        " Gaussians, the scene " + std::to_string(scene.model.size()) +
        "; run stage bootstrap again");
  }
  FREEGS_ASSIGN_OR_RETURN(report->instances,
                          MeasureInstanceQuality(scene,
                                                 idsf.instances,
                                                 truth,
                                                 truth_from_scene,
                                                 EvaluationOptions(),
                                                 context.cancellation,
                                                 pool));
  return Status();
}

}  // namespace

Status RunEvalCommand(const std::vector<std::string>& arguments,
                      CommandContext& context) {
  PipelineOptions options;
  pipeline::OptionTable table = MakeOptionTable(&options);
  std::string truth;
  std::string json_file;
  table.Add("gt",
            &truth,
            {.help = "Folder with the truth: gt/cameras.json, "
                     "gt/objects.json, gt/instance/, test/images/."});
  table.Add("json",
            &json_file,
            {.help = "File to write the figures to; - is standard output."});
  FREEGS_ASSIGN_OR_RETURN(const pipeline::OptionTable::CommandLine line,
                          table.ParseCommandLine(arguments));
  if (line.positional.size() != 1) {
    return InvalidArgumentError(
        "eval takes one workspace: eval WORKSPACE [--gt DIR] [--json FILE]");
  }
  std::error_code error;
  const fs::path workspace =
      fs::absolute(line.positional[0], error).lexically_normal();
  if (!fs::is_directory(workspace, error)) {
    return BadInputError(workspace.string() + ": no such workspace");
  }
  FREEGS_RETURN_IF_ERROR(ApplySettings(workspace, line.settings, table));
  ThreadPool pool(options.general.threads);

  FREEGS_ASSIGN_OR_RETURN(const WorkspaceScene scene,
                          ReadWorkspaceScene(workspace));
  EvaluationReport report;
  report.workspace = workspace.string();
  report.num_gaussians = scene.model.size();
  report.num_photos = scene.train.size() + scene.holdout.size();
  FREEGS_ASSIGN_OR_RETURN(
      report.holdout,
      MeasureHoldoutQuality(scene, workspace / "undistort" / "images", pool));
  if (!truth.empty()) {
    FREEGS_RETURN_IF_ERROR(
        CompareWithTruth(truth, workspace, scene, context, pool, &report));
  }
  if (json_file == "-") {
    context.out << pipeline::JsonText(ToJson(report));
    return Status();
  }
  PrintTable(report, context.out);
  if (json_file.empty()) return Status();
  return WriteFileAtomic(json_file, pipeline::JsonText(ToJson(report)));
}

}  // namespace freegs::stages
