// SPDX-License-Identifier: BSD-3-Clause

#include "stages/sfm/undistort_stage.h"

#include <algorithm>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

#include "pipeline/system_info.h"
#include "sfm/colmap/undistortion.h"
#include "sfm/scene/model_io.h"
#include "stages/sfm/photo_masks.h"
#include "stages/sfm/sfm_forecast.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;
using pipeline::StageContext;

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
    const int cores = pipeline::AvailableCores();
    const auto processors =
        static_cast<int>(std::thread::hardware_concurrency());
    pipeline::StageNeed need =
        UndistortNeed(*scene, cores, std::max(cores, processors));
    for (auto* views : {&scene->train, &scene->holdout}) {
      for (View& view : *views) {
        view.camera = view.camera.LimitedTo(options_.max_image_size);
      }
    }
    if (done) {
      SetSceneToModel(context.workspace / "undistort" / "sparse", scene);
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
      FREEGS_RETURN_IF_ERROR(
          WriteUndistortedMasks(model, result.model, context));
    }
    context.summary["undistorted"] = true;
    context.summary["resampled"] = result.resampled;
    context.summary["images"] = result.model.images.size();
    context.log(pipeline::LogLevel::kInfo,
                std::to_string(result.model.images.size()) +
                    (result.resampled
                         ? " photos written without distortion"
                         : " photos have no distortion and are kept as they "
                           "are"));
    return {};
  }

 private:
  UndistortStageOptions options_;
  std::string colmap_;
};

}  // namespace

std::unique_ptr<pipeline::Stage> MakeUndistortStage(
    const UndistortStageOptions& options, const std::string& colmap) {
  return std::make_unique<UndistortStage>(options, colmap);
}

}  // namespace freegs::stages
