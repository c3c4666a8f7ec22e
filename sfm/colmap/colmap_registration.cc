// SPDX-License-Identifier: BSD-3-Clause
// The registration step: poses for photos that see the points of a model.

#include <algorithm>
#include <set>
#include <system_error>

#include "core/io/files.h"
#include "sfm/colmap/colmap_output.h"
#include "sfm/colmap/colmap_steps.h"
#include "sfm/scene/model_io.h"

namespace freegs::sfm {

namespace fs = std::filesystem;

namespace {

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
  const std::string command = "image_registrator";
  std::error_code ignored;
  fs::remove_all(folder, ignored);
  const fs::path given = folder / "start";
  const fs::path output = folder / "model";
  FREEGS_RETURN_IF_ERROR(WriteModel(given, model));
  FREEGS_RETURN_IF_ERROR(CreateFolders(output));
  FREEGS_ASSIGN_OR_RETURN(
      ColmapArguments arguments,
      context.Arguments(command, context.input.photos.size()));
  arguments.Require("database_path", database.string());
  arguments.Require("input_path", given.string());
  arguments.Require("output_path", output.string());
  // One thread: random numbers are then always drawn in the same order.
  arguments.AddAll({"Mapper.num_threads"}, "1");
  arguments.AddAll({"random_seed", "default_random_seed", "Mapper.random_seed"},
                   std::to_string(context.input.seed % 2147483647));
  FREEGS_ASSIGN_OR_RETURN(const ChildCommand run, arguments.Finish());

  const double total = static_cast<double>(context.input.photos.size());
  const std::string step = "mapping, the others";
  context.Report(step, static_cast<double>(model.images.size()), total, "");
  const auto on_line = [&](std::string_view line) {
    const auto progress = ParseColmapLine(line);
    if (!progress || progress->kind != ColmapProgress::Kind::kPhotoRegistered) {
      return;
    }
    context.Report(step, std::min<double>(progress->done, total), total, "");
  };
  FREEGS_ASSIGN_OR_RETURN(const ChildResult result,
                          RunChild(run, on_line, context.input.cancellation));
  const Status ended = CheckEnded(context, command, result, Crash::kVerdict);
  if (!ended.ok()) {
    fs::remove_all(folder, ignored);
    return ended;
  }
  StatusOr<Reconstruction> all = ReadModelUnchecked(output);
  fs::remove_all(folder, ignored);
  if (!all.ok()) {
    return InternalError("COLMAP's model cannot be read (is the disk full?): " +
                         all.status().message());
  }
  Reconstruction model_of_all = WithSensibleCameras(*all);
  const Status consistent = CheckReconstruction(model_of_all);
  if (!consistent.ok()) return UnusableResultError(consistent.message());
  return model_of_all;
}

}  // namespace freegs::sfm
