// SPDX-License-Identifier: BSD-3-Clause
// The mapping step, and what the steps share.

#include <algorithm>
#include <csignal>
#include <system_error>

#include "core/io/files.h"
#include "core/number_text.h"
#include "sfm/colmap/colmap_output.h"
#include "sfm/colmap/colmap_steps.h"
#include "sfm/scene/model_io.h"

namespace freegs::sfm {
namespace {

namespace fs = std::filesystem;

// Adds the model of a folder. With few photos COLMAP may end with cameras that
// no photograph has, such as a focal length of 17 pixels: that is no model.
Status AddModel(const fs::path& folder, std::vector<Reconstruction>* models) {
  FREEGS_ASSIGN_OR_RETURN(Reconstruction model, ReadModelUnchecked(folder));
  if (!CheckReconstruction(model).ok()) return {};
  RemoveDanglingReferences(&model);
  if (!model.images.empty()) models->push_back(std::move(model));
  return {};
}

// COLMAP numbers its models 0, 1, ... in the order in which it made them. One
// that was continued lies in the folder itself.
StatusOr<std::vector<Reconstruction>> ReadModels(const fs::path& folder) {
  std::vector<Reconstruction> models;
  if (DetectModelFormat(folder)) {
    FREEGS_RETURN_IF_ERROR(AddModel(folder, &models));
    return models;
  }
  for (int i = 0; DetectModelFormat(folder / std::to_string(i)); ++i) {
    FREEGS_RETURN_IF_ERROR(AddModel(folder / std::to_string(i), &models));
  }
  return models;
}

// COLMAP adjusts all cameras and points whenever the model has grown by a
// tenth, and up to five times as long as that changes what fits. This takes
// most of the mapper's time; once, when it has grown by a third, is as
// accurate. Further attempts, on photos that make difficulties, leave it as it
// is.
void AdjustLessOften(ColmapArguments* arguments) {
  arguments->Prefer(
      {"Mapper.ba_global_frames_ratio", "Mapper.ba_global_images_ratio"},
      "1.3");
  arguments->Prefer({"Mapper.ba_global_points_ratio"}, "1.3");
  arguments->Prefer({"Mapper.ba_global_max_refinements"}, "1");
  arguments->Prefer({"Mapper.ba_local_max_refinements"}, "1");
  arguments->Prefer({"Mapper.ba_local_max_num_iterations"}, "15");
}

// COLMAP ends an adjustment when nothing moves any more, or after 50
// iterations. Nearly all of the gain is in the first few. Unless the user gave
// the lens model, the last adjustment is our own (camera_selection.h).
void EndAdjustmentsEarly(ColmapArguments* arguments) {
  arguments->Prefer({"Mapper.ba_global_function_tolerance"}, "1e-4");
  arguments->Prefer({"Mapper.ba_local_function_tolerance"}, "1e-4");
}

// Whether a program brings the signal upon itself by an error in it.
bool IsFault(int signal) {
  return signal == SIGSEGV || signal == SIGABRT || signal == SIGBUS ||
         signal == SIGFPE || signal == SIGILL;
}

// COLMAP gives a full disk no exit code of its own.
bool IsDiskFull(const fs::path& folder) {
  constexpr uintmax_t kNoRoom = 8 << 20;
  std::error_code error;
  const fs::space_info space = fs::space(folder, error);
  return !error && space.available < kNoRoom;
}

// COLMAP looks at the pair itself, by its own estimate of the motion, and makes
// no model if that falls short of its limits.
void BeginWith(const InitialPair& pair, ColmapArguments* arguments) {
  constexpr double kUsualInliers = 100;
  arguments->Require("Mapper.init_image_id1", std::to_string(pair.id1));
  arguments->Require("Mapper.init_image_id2", std::to_string(pair.id2));
  // Otherwise COLMAP begins there again and again while photos are left.
  arguments->Require("Mapper.multiple_models", "0");
  const double inliers = static_cast<double>(pair.matches) / 2;
  arguments->Prefer({"Mapper.init_min_num_inliers"},
                    FormatFixed(std::min(kUsualInliers, inliers), 0));
  arguments->Prefer(
      {"Mapper.init_min_tri_angle"},
      FormatFixed(std::min(kUsualStartAngleDeg, pair.angle_deg / 2), 3));
}

// The names of the photos, one in each line.
std::string ListOf(const std::vector<SfmPhoto>& photos) {
  std::string list;
  for (const SfmPhoto& photo : photos) list += photo.name + "\n";
  return list;
}

// Where the mapper is to put its models, in the folder of MapPhotos.
fs::path ModelsFolder(const fs::path& folder) { return folder / "models"; }

// The mapper's command. The model that it begins with is written to `folder`.
StatusOr<ChildCommand> MapperCommand(const StepContext& context,
                                     const fs::path& database,
                                     const fs::path& folder,
                                     const MapperOptions& options) {
  FREEGS_ASSIGN_OR_RETURN(
      ColmapArguments arguments,
      context.Arguments("mapper", context.input.photos.size()));
  arguments.Require("database_path", database.string());
  arguments.Require("image_path", context.input.photo_folder.string());
  arguments.Require("output_path", ModelsFolder(folder).string());
  if (options.start != nullptr) {
    const fs::path start = folder / "start";
    FREEGS_RETURN_IF_ERROR(WriteModel(start, *options.start));
    arguments.Require("input_path", start.string());
  }
  if (options.listed) {
    const fs::path list = folder / "image_list.txt";
    FREEGS_RETURN_IF_ERROR(WriteFileAtomic(list, ListOf(context.input.photos)));
    arguments.Require("image_list_path", list.string());
  }
  context.MakeRepeatable(&arguments);
  arguments.Prefer({"Mapper.extract_colors"}, "0");
  EndAdjustmentsEarly(&arguments);
  if (options.start == nullptr && options.pair) {
    BeginWith(*options.pair, &arguments);
  }
  if (!options.relaxed) {
    AdjustLessOften(&arguments);
  } else {
    if (!options.pair) {
      arguments.Prefer({"Mapper.init_min_num_inliers"}, "40");
      arguments.Prefer({"Mapper.init_min_tri_angle"}, "4");
    }
    arguments.Prefer({"Mapper.abs_pose_min_num_inliers"}, "15");
    arguments.Prefer({"Mapper.abs_pose_min_inlier_ratio"}, "0.15");
  }
  if (options.small_models) arguments.Prefer({"Mapper.min_model_size"}, "3");
  return arguments.Finish();
}

// The models of a mapper that has ended, the largest first. Deletes `folder`
// once they are read.
StatusOr<std::vector<Reconstruction>> TakeModels(const StepContext& context,
                                                 const fs::path& folder,
                                                 const MapperOptions& options,
                                                 const ChildResult& result) {
  const Status ended =
      CheckEnded(context,
                 "mapper",
                 result,
                 options.further ? Crash::kVerdict : Crash::kNoVerdict);
  // COLMAP returns 1 when it made no model: that is a result, not a failure. It
  // does the same when it cannot read the database.
  const bool no_model = result.exit_code == 1 &&
                        ended.code() == StatusCode::kUnusableResult &&
                        result.tail.find("SQLite error") == std::string::npos;
  if (!ended.ok() && !no_model) return ended;
  StatusOr<std::vector<Reconstruction>> read = ReadModels(ModelsFolder(folder));
  if (!read.ok()) {
    return InternalError("COLMAP's model cannot be read (is the disk full?): " +
                         read.status().message());
  }
  std::error_code error;
  fs::remove_all(folder, error);
  if (!ended.ok() && !read->empty()) return ended;
  SortBySize(&*read);
  return read;
}

}  // namespace

void SortBySize(std::vector<Reconstruction>* models) {
  std::stable_sort(models->begin(),
                   models->end(),
                   [](const Reconstruction& a, const Reconstruction& b) {
                     return std::pair(a.images.size(), a.points3d.size()) >
                            std::pair(b.images.size(), b.points3d.size());
                   });
}

fs::path StepContext::LogFile(const std::string& command) const {
  return input.work_folder / "logs" / (command + ".log");
}

StatusOr<ColmapArguments> StepContext::Arguments(const std::string& command,
                                                 size_t photos) const {
  FREEGS_ASSIGN_OR_RETURN(std::set<std::string> known,
                          colmap.Options(command, input.cancellation));
  ChildCommand child = colmap.Command(command);
  child.log_file = LogFile(command);
  child.time_limit_s = TimeLimit(photos);
  return ColmapArguments(std::move(child), std::move(known));
}

void StepContext::MakeRepeatable(ColmapArguments* arguments) const {
  // One thread: sums are then always in the same order, and so are the random
  // numbers.
  arguments->AddAll({"Mapper.num_threads"}, "1");
  arguments->AddAll(
      {"random_seed", "default_random_seed", "Mapper.random_seed"},
      std::to_string(input.seed % 2147483647));
}

void StepContext::Report(const std::string& step,
                         double done,
                         double total,
                         const std::string& detail) const {
  if (input.progress) input.progress({step, done, total, detail});
}

Status CheckEnded(const std::string& program,
                  const std::string& command,
                  const fs::path& log,
                  const ChildResult& result,
                  Crash crash) {
  if (result.ok()) return {};
  std::string message =
      "'" + program + " " + command + "' failed with " + result.Describe();
  if (result.signal == SIGKILL && !result.timed_out) {
    message +=
        ", as the system does when memory runs out (end other programs, use "
        "fewer threads, or lower sfm.max_image_size or sfm.max_features)";
  }
  message += "; log: " + log.string();
  if (!result.tail.empty()) message += "; its last lines:\n" + result.tail;
  if (IsDiskFull(log.parent_path())) {
    return InternalError("the disk is full: " + message);
  }
  // Other signals are no verdict on the photos, and neither is an end of which
  // nothing is known.
  const bool verdict = result.timed_out || result.exit_code >= 0 ||
                       (crash == Crash::kVerdict && IsFault(result.signal));
  return verdict ? UnusableResultError(message) : InternalError(message);
}

Status CheckEnded(const StepContext& context,
                  const std::string& command,
                  const ChildResult& result,
                  Crash crash) {
  return CheckEnded(context.colmap.program(),
                    command,
                    context.LogFile(command),
                    result,
                    crash);
}

double TimeLimit(size_t photos) {
  // Some hundred times what a slow machine needs.
  return 1800 + 120 * static_cast<double>(photos);
}

StatusOr<std::vector<Reconstruction>> MapPhotos(const StepContext& context,
                                                const fs::path& database,
                                                const fs::path& folder,
                                                const MapperOptions& options) {
  std::error_code error;
  fs::remove_all(folder, error);
  FREEGS_RETURN_IF_ERROR(CreateFolders(ModelsFolder(folder)));
  FREEGS_ASSIGN_OR_RETURN(const ChildCommand run,
                          MapperCommand(context, database, folder, options));

  const double total = static_cast<double>(context.input.photos.size());
  double registered = options.start == nullptr
                          ? 0
                          : static_cast<double>(options.start->images.size());
  context.Report(options.step, registered, total, "");
  const auto on_line = [&](std::string_view line) {
    const auto progress = ParseColmapLine(line);
    if (!progress) return;
    if (progress->kind == ColmapProgress::Kind::kPhotoRegistered) {
      registered = std::min<double>(progress->done, total);
      context.Report(options.step, registered, total, "");
    } else if (progress->kind == ColmapProgress::Kind::kAdjusting) {
      context.Report(options.step, registered, total, "adjusting all of them");
    }
  };
  FREEGS_ASSIGN_OR_RETURN(const ChildResult result,
                          RunChild(run, on_line, context.input.cancellation));
  return TakeModels(context, folder, options, result);
}

}  // namespace freegs::sfm
