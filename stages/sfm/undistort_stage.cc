// SPDX-License-Identifier: BSD-3-Clause

#include "stages/sfm/undistort_stage.h"

#include <algorithm>
#include <map>
#include <string>
#include <system_error>
#include <vector>

#include "core/io/files.h"
#include "core/io/image_io.h"
#include "pipeline/system_info.h"
#include "sfm/colmap/undistortion.h"
#include "sfm/scene/mask_undistortion.h"
#include "sfm/scene/model_io.h"
#include "stages/sfm/sfm_forecast.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;
using pipeline::StageContext;

// A mask of ingest, which must have the size of its photo's camera.
StatusOr<ImageU8> ReadMask(const fs::path& path, const sfm::Camera& camera) {
  FREEGS_ASSIGN_OR_RETURN(const ImageU16 labels, ReadLabels(path));
  if (static_cast<uint64_t>(labels.width()) != camera.width ||
      static_cast<uint64_t>(labels.height()) != camera.height) {
    return BadInputError(path.string() +
                         ": the mask does not have the size of the camera of "
                         "its photo");
  }
  ImageU8 mask(labels.width(), labels.height(), 1);
  std::transform(labels.data(),
                 labels.data() + labels.size(),
                 mask.data(),
                 [](uint16_t v) { return static_cast<uint8_t>(v != 0); });
  return mask;
}

class UndistortStage : public pipeline::Stage {
 public:
  UndistortStage(const UndistortStageOptions& options, std::string colmap)
      : options_(options), colmap_(std::move(colmap)) {}

  std::string_view name() const override { return "undistort"; }

  std::vector<fs::path> Inputs(const StageContext& context) const override {
    std::vector<fs::path> inputs = {"ingest/photos", "sfm/sparse/0"};
    if (HasMasks(context)) inputs.emplace_back("ingest/masks");
    return inputs;
  }

  std::vector<std::string> Disposable() const override { return {"logs"}; }

  pipeline::StageNeed Foretell(const StageContext& context,
                               bool done,
                               pipeline::SceneOutlook* scene) const override {
    // COLMAP's undistorter takes all cores.
    pipeline::StageNeed need =
        UndistortNeed(*scene, pipeline::AvailableCores());
    for (auto* views : {&scene->train, &scene->holdout}) {
      for (View& view : *views) {
        view.camera = view.camera.LimitedTo(options_.max_image_size);
      }
    }
    if (done) {
      ShowModel(context.workspace / "undistort" / "sparse", scene);
      std::error_code error;
      scene->masks =
          fs::is_directory(context.workspace / "undistort" / "masks", error);
    }
    return need;
  }

  Status Run(StageContext& context) override {
    FREEGS_ASSIGN_OR_RETURN(
        sfm::Reconstruction model,
        sfm::ReadModel(context.workspace / "sfm" / "sparse" / "0"));
    // A model that somebody else put there may be inconsistent.
    sfm::RemoveDanglingReferences(&model);
    sfm::UndistortionInput input;
    input.photo_folder = context.workspace / "ingest" / "photos";
    input.output = context.output;
    input.colmap = colmap_;
    input.max_image_size = options_.max_image_size;
    input.cancellation = context.cancellation;
    input.progress = context.progress;
    FREEGS_ASSIGN_OR_RETURN(const sfm::UndistortionResult result,
                            sfm::Undistort(model, input));
    std::error_code error;
    fs::remove_all(context.output / "masks", error);
    if (HasMasks(context)) {
      FREEGS_RETURN_IF_ERROR(WriteMasks(model, result.model, context));
    }
    context.summary["undistorted"] = true;
    context.summary["resampled"] = result.resampled;
    context.summary["images"] = result.model.images.size();
    context.log(pipeline::LogLevel::kInfo,
                "undistort: " + std::to_string(result.model.images.size()) +
                    (result.resampled
                         ? " photos written without distortion"
                         : " photos have no distortion and are kept as they "
                           "are"));
    return {};
  }

 private:
  static bool HasMasks(const StageContext& context) {
    std::error_code error;
    return fs::is_directory(context.workspace / "ingest" / "masks", error);
  }

  // Writes masks/NAME.png for every photo NAME that has a mask, as the
  // undistorted photo needs it.
  static Status WriteMasks(const sfm::Reconstruction& distorted,
                           const sfm::Reconstruction& pinhole,
                           const StageContext& context) {
    const auto from = sfm::IndexCameras(distorted);
    const auto to = sfm::IndexCameras(pinhole);
    std::map<std::string, uint32_t> camera_of;
    for (const sfm::PosedImage& image : distorted.images) {
      camera_of[image.name] = image.camera_id;
    }
    for (const sfm::PosedImage& image : pinhole.images) {
      if (context.cancellation->cancelled()) {
        return InterruptedError("stopped on request");
      }
      const auto source = camera_of.find(image.name);
      const fs::path name(image.name + ".png");
      const fs::path path = context.workspace / "ingest" / "masks" / name;
      std::error_code error;
      if (source == camera_of.end() || !fs::exists(path, error)) continue;
      const sfm::Camera& camera = distorted.cameras[from.at(source->second)];
      FREEGS_ASSIGN_OR_RETURN(const ImageU8 mask, ReadMask(path, camera));
      const fs::path target = context.output / "masks" / name;
      FREEGS_RETURN_IF_ERROR(CreateFolders(target.parent_path()));
      FREEGS_RETURN_IF_ERROR(WriteImage(
          target,
          sfm::UndistortMask(
              mask, camera, pinhole.cameras[to.at(image.camera_id)])));
    }
    return Status();
  }

  UndistortStageOptions options_;
  std::string colmap_;
};

}  // namespace

void RegisterUndistortOptions(UndistortStageOptions& options,
                              pipeline::OptionTable& table) {
  table.AddSection("undistort", "Photos and cameras without lens distortion.");
  table.Add("undistort.max_image_size",
            &options.max_image_size,
            {.help = "Longest side in pixels of the written photos; 0 keeps "
                     "their own.",
             .min = 0,
             .max = 100000});
}

std::unique_ptr<pipeline::Stage> MakeUndistortStage(
    const UndistortStageOptions& options, const std::string& colmap) {
  return std::make_unique<UndistortStage>(options, colmap);
}

}  // namespace freegs::stages
