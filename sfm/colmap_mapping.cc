// SPDX-License-Identifier: BSD-3-Clause
// The mapping step, and what the steps share.

#include <algorithm>
#include <system_error>

#include "core/files.h"
#include "sfm/colmap_output.h"
#include "sfm/colmap_steps.h"
#include "sfm/model_io.h"

namespace freegs::sfm {
namespace {

namespace fs = std::filesystem;

// COLMAP numbers its models 0, 1, ... in the order in which it made them.
StatusOr<std::vector<Reconstruction>> ReadModels(const fs::path& folder) {
  std::vector<Reconstruction> models;
  for (int i = 0; DetectModelFormat(folder / std::to_string(i)); ++i) {
    FREEGS_ASSIGN_OR_RETURN(Reconstruction model,
                            ReadModel(folder / std::to_string(i)));
    RemoveDanglingReferences(&model);
    if (!model.images.empty()) models.push_back(std::move(model));
  }
  return models;
}

}  // namespace

fs::path StepContext::LogFile(const std::string& command) const {
  return input.work_folder / "logs" / (command + ".log");
}

void StepContext::Report(const std::string& step,
                         double done,
                         double total,
                         const std::string& detail) const {
  if (input.progress) input.progress({step, done, total, detail});
}

Status CheckEnded(const StepContext& context,
                  const std::string& command,
                  const ChildResult& result) {
  if (result.ok()) return {};
  return UnusableResultError("'" + context.colmap.program() + " " + command +
                             "' failed with " + result.Describe() +
                             "; log: " + context.LogFile(command).string() +
                             "; its last lines:\n" + result.tail);
}

StatusOr<std::vector<Reconstruction>> MapPhotos(const StepContext& context,
                                                const fs::path& database,
                                                const fs::path& folder,
                                                bool relaxed) {
  const std::string command = "mapper";
  std::error_code error;
  fs::remove_all(folder, error);
  FREEGS_RETURN_IF_ERROR(CreateFolders(folder));

  FREEGS_ASSIGN_OR_RETURN(
      const std::set<std::string> options,
      context.colmap.Options(command, context.input.cancellation));
  ChildCommand child = context.colmap.Command(command);
  child.log_file = context.LogFile(command);
  ColmapArguments arguments(std::move(child), options);
  arguments.Require("database_path", database.string());
  arguments.Require("image_path", context.input.photo_folder.string());
  arguments.Require("output_path", folder.string());
  // One thread: sums of bundle adjustment are then always in the same order.
  arguments.Prefer({"Mapper.num_threads"}, "1");
  arguments.AddAll({"random_seed", "default_random_seed", "Mapper.random_seed"},
                   std::to_string(context.input.seed % 2147483647));
  if (relaxed) {
    arguments.Prefer({"Mapper.init_min_num_inliers"}, "40");
    arguments.Prefer({"Mapper.init_min_tri_angle"}, "4");
    arguments.Prefer({"Mapper.abs_pose_min_num_inliers"}, "15");
    arguments.Prefer({"Mapper.abs_pose_min_inlier_ratio"}, "0.15");
  }
  FREEGS_ASSIGN_OR_RETURN(const ChildCommand run, arguments.Finish());

  const double total = static_cast<double>(context.input.photos.size());
  const std::string step = relaxed ? "mapping, lower thresholds" : "mapping";
  context.Report(step, 0, total, "");
  const auto on_line = [&](std::string_view line) {
    const auto progress = ParseColmapLine(line);
    if (!progress || progress->kind != ColmapProgress::Kind::kPhotoRegistered) {
      return;
    }
    context.Report(step, std::min<double>(progress->done, total), total, "");
  };
  FREEGS_ASSIGN_OR_RETURN(const ChildResult result,
                          RunChild(run, on_line, context.input.cancellation));
  FREEGS_ASSIGN_OR_RETURN(std::vector<Reconstruction> models,
                          ReadModels(folder));
  // COLMAP returns 1 when it made no model: that is a result, not a failure.
  if (result.exit_code == 1 && models.empty()) return models;
  FREEGS_RETURN_IF_ERROR(CheckEnded(context, command, result));
  return models;
}

}  // namespace freegs::sfm
