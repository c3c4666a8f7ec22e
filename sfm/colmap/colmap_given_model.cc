// SPDX-License-Identifier: BSD-3-Clause
// The steps that begin with a given model: poses for further photos, and points
// for known poses.

#include <algorithm>
#include <set>
#include <system_error>

#include "core/io/files.h"
#include "sfm/colmap/colmap_output.h"
#include "sfm/colmap/colmap_steps.h"
#include "sfm/scene/model_io.h"

namespace freegs::sfm {
namespace {

namespace fs = std::filesystem;

Status UnreadableModel(const Status& status) {
  return InternalError("COLMAP's model cannot be read (is the disk full?): " +
                       status.message());
}

// Runs a COLMAP command that makes one model of another, and reports each photo
// that it says to have done as progress of `step`. `done` is how many of
// `total` there are before. `prepare` adds what only this command needs. The
// result is not checked. `folder` is made anew and deleted at the end.
StatusOr<Reconstruction> RunOnModel(
    const StepContext& context,
    const std::string& command,
    const fs::path& database,
    const fs::path& folder,
    const Reconstruction& model,
    const std::function<void(const fs::path& given, ColmapArguments*)>& prepare,
    const std::string& step,
    size_t done,
    size_t total,
    ColmapProgress::Kind kind) {
  std::error_code ignored;
  fs::remove_all(folder, ignored);
  const fs::path given = folder / "given";
  const fs::path output = folder / "model";
  FREEGS_RETURN_IF_ERROR(WriteModel(given, model));
  FREEGS_RETURN_IF_ERROR(CreateFolders(output));
  FREEGS_ASSIGN_OR_RETURN(ColmapArguments arguments,
                          context.Arguments(command, total));
  arguments.Require("database_path", database.string());
  arguments.Require("input_path", given.string());
  arguments.Require("output_path", output.string());
  prepare(given, &arguments);
  context.MakeRepeatable(&arguments);
  FREEGS_ASSIGN_OR_RETURN(const ChildCommand run, arguments.Finish());

  const auto count = static_cast<double>(total);
  context.Report(step, static_cast<double>(done), count, "");
  const auto on_line = [&](std::string_view line) {
    const auto progress = ParseColmapLine(line);
    if (!progress || progress->kind != kind) return;
    context.Report(step, std::min<double>(progress->done, count), count, "");
  };
  FREEGS_ASSIGN_OR_RETURN(const ChildResult result,
                          RunChild(run, on_line, context.input.cancellation));
  const Status ended = CheckEnded(context, command, result, Crash::kVerdict);
  if (!ended.ok()) {
    fs::remove_all(folder, ignored);
    return ended;
  }
  StatusOr<Reconstruction> made = ReadModelUnchecked(output);
  fs::remove_all(folder, ignored);
  if (!made.ok()) return UnreadableModel(made.status());
  return made;
}

// The lens of a photo with a camera of its own is estimated from that photo
// alone, and may be one that no photo has.
Reconstruction WithSensibleCameras(const Reconstruction& model) {
  std::set<uint32_t> sensible;
  for (const Camera& camera : model.cameras) {
    if (camera.Check().ok()) sensible.insert(camera.id);
  }
  std::vector<uint32_t> ids;
  for (const PosedImage& image : model.images) {
    if (sensible.contains(image.camera_id)) ids.push_back(image.id);
  }
  return RestrictTo(model, ids);
}

}  // namespace

StatusOr<Reconstruction> RegisterOtherPhotos(const StepContext& context,
                                             const fs::path& database,
                                             const fs::path& folder,
                                             const Reconstruction& model) {
  FREEGS_ASSIGN_OR_RETURN(const Reconstruction registered,
                          RunOnModel(
                              context,
                              "image_registrator",
                              database,
                              folder,
                              model,
                              [](const fs::path&, ColmapArguments*) {},
                              "mapping, the others",
                              model.images.size(),
                              context.input.photos.size(),
                              ColmapProgress::Kind::kPhotoRegistered));
  Reconstruction all = WithSensibleCameras(registered);
  const Status consistent = CheckReconstruction(all);
  if (!consistent.ok()) return UnusableResultError(consistent.message());
  return all;
}

StatusOr<Reconstruction> TriangulatePoints(const StepContext& context,
                                           const fs::path& database,
                                           const fs::path& folder,
                                           const Reconstruction& poses) {
  const auto prepare = [](const fs::path& given, ColmapArguments* arguments) {
    // COLMAP would decode all photos to colour the points, and goes without if
    // they are not there.
    arguments->Require("image_path", given.string());
    arguments->Prefer({"Mapper.extract_colors"}, "0");
    // The points move alone, and nearly all of what they gain comes early.
    arguments->Prefer({"Mapper.ba_global_max_refinements"}, "1");
    arguments->Prefer({"Mapper.ba_global_function_tolerance"}, "1e-4");
  };
  // Release 3.8 aborts when the matches show no points from these poses.
  FREEGS_ASSIGN_OR_RETURN(Reconstruction model,
                          RunOnModel(context,
                                     "point_triangulator",
                                     database,
                                     folder,
                                     poses,
                                     prepare,
                                     "points",
                                     0,
                                     poses.images.size(),
                                     ColmapProgress::Kind::kPhotoTriangulated));
  const Status consistent = CheckReconstruction(model);
  if (!consistent.ok()) return UnreadableModel(consistent);
  RemoveDanglingReferences(&model);
  return model;
}

}  // namespace freegs::sfm
