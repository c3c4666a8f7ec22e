// SPDX-License-Identifier: BSD-3-Clause
// The triangulation step: points for cameras whose poses are known.

#include <algorithm>
#include <system_error>

#include "core/io/files.h"
#include "sfm/colmap/colmap_output.h"
#include "sfm/colmap/colmap_steps.h"
#include "sfm/scene/model_io.h"

namespace freegs::sfm {

namespace fs = std::filesystem;

StatusOr<Reconstruction> TriangulatePoints(const StepContext& context,
                                           const fs::path& database,
                                           const fs::path& folder,
                                           const Reconstruction& poses) {
  const std::string command = "point_triangulator";
  std::error_code ignored;
  fs::remove_all(folder, ignored);
  const fs::path given = folder / "poses";
  const fs::path output = folder / "model";
  FREEGS_RETURN_IF_ERROR(WriteModel(given, poses));
  FREEGS_RETURN_IF_ERROR(CreateFolders(output));
  FREEGS_ASSIGN_OR_RETURN(ColmapArguments arguments,
                          context.Arguments(command, poses.images.size()));
  arguments.Require("database_path", database.string());
  // COLMAP would decode all photos to colour the points, and goes without if
  // they are not there.
  arguments.Require("image_path", given.string());
  arguments.Require("input_path", given.string());
  arguments.Require("output_path", output.string());
  arguments.Prefer({"Mapper.extract_colors"}, "0");
  // The points move alone, and nearly all of what they gain comes early.
  arguments.Prefer({"Mapper.ba_global_max_refinements"}, "1");
  arguments.Prefer({"Mapper.ba_global_function_tolerance"}, "1e-4");
  // One thread: sums of bundle adjustment are then always in the same order.
  arguments.AddAll({"Mapper.num_threads"}, "1");
  arguments.AddAll({"random_seed", "default_random_seed", "Mapper.random_seed"},
                   std::to_string(context.input.seed % 2147483647));
  FREEGS_ASSIGN_OR_RETURN(const ChildCommand run, arguments.Finish());
  const double total = static_cast<double>(poses.images.size());
  context.Report("points", 0, total, "");
  const auto on_line = [&](std::string_view line) {
    const auto progress = ParseColmapLine(line);
    if (progress &&
        progress->kind == ColmapProgress::Kind::kPhotoTriangulated) {
      context.Report(
          "points", std::min<double>(progress->done, total), total, "");
    }
  };
  FREEGS_ASSIGN_OR_RETURN(const ChildResult result,
                          RunChild(run, on_line, context.input.cancellation));
  // Release 3.8 aborts when the matches show no points from these poses.
  const Status ended = CheckEnded(context, command, result, Crash::kVerdict);
  if (!ended.ok()) {
    fs::remove_all(folder, ignored);
    return ended;
  }
  StatusOr<Reconstruction> model = ReadModel(output);
  fs::remove_all(folder, ignored);
  if (!model.ok()) {
    return InternalError("COLMAP's model cannot be read (is the disk full?): " +
                         model.status().message());
  }
  RemoveDanglingReferences(&*model);
  return model;
}

}  // namespace freegs::sfm
