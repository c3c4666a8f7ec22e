// SPDX-License-Identifier: BSD-3-Clause

#include "stages/reconstruct/reconstruct_stage.h"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/cancellation.h"
#include "core/io/files.h"
#include "core/io/image_io.h"
#include "core/io/json_text.h"
#include "core/number_text.h"
#include "pipeline/resource_usage.h"
#include "pipeline/system_info.h"
#include "splat/images/holdout.h"
#include "splat/scene/ply_io.h"
#include "splat/scene/spz_format.h"
#include "splat/train/trainer.h"
#include "stages/reconstruct/reconstruct_forecast.h"
#include "stages/reconstruct/training_report.h"
#include "stages/reconstruct/training_run.h"
#include "stages/scene/exposure_file.h"
#include "stages/scene/scene_size.h"
#include "stages/scene/training_scene.h"
#include "stages/scene/working_frame.h"
#include "stages/scene/workspace_scene.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;

// A model that somebody else trained, for a scene in `frame`.
StatusOr<splat::PlacedModel> ReadTrainedModel(const fs::path& path,
                                              const splat::ModelFrame& frame) {
  const std::string suffix = LowerSuffix(path);
  if (suffix == ".ply") return splat::ReadPly(path);
  if (suffix != ".spz") {
    return BadInputError(path.string() +
                         ": .ply and .spz can be imported; .splat lacks "
                         "view-dependent colour");
  }
  // Its positions may count from any point near the scene.
  if (frame.IsFarAway()) {
    return BadInputError(path.string() +
                         ": the scene lies far from the origin of its world, "
                         "and an .spz cannot say where; import the .ply");
  }
  splat::PlacedModel world;
  FREEGS_ASSIGN_OR_RETURN(world.model, splat::ReadSpz(path));
  return world;
}

class ReconstructStage : public pipeline::Stage {
 public:
  ReconstructStage(const ReconstructStageOptions& options, uint64_t seed)
      : options_(options), seed_(seed) {}

  std::string_view name() const override { return "reconstruct"; }
  int version() const override { return 14; }

  std::vector<fs::path> Inputs(
      const pipeline::StageContext& context) const override {
    std::vector<fs::path> inputs = {
        "undistort/images", "undistort/sparse", "ingest/images.json"};
    if (!TrainingMaskFolder(context.workspace).empty()) {
      inputs.emplace_back("undistort/masks");
    }
    if (!options_.import.empty()) inputs.emplace_back(options_.import);
    return inputs;
  }

  std::vector<std::string> Disposable() const override {
    return {"checkpoints"};
  }

  pipeline::StageNeed Foretell(const pipeline::StageContext& context,
                               bool done,
                               pipeline::SceneOutlook* scene) const override {
    pipeline::StageNeed need;
    const bool imported = !options_.import.empty();
    if (imported) {
      scene->gaussians = CountGaussians(options_.import).value_or(0);
    }
    const bool unread = imported && scene->gaussians == 0;
    const auto training = TrainingOptions(scene->train);
    if (training.ok()) {
      need = ReconstructNeed(
          options_, *training, context.pool->num_threads(), scene);
    }
    if (unread) {
      need.unknown_reason =
          options_.import + ": no Gaussians of a .ply or .spz found";
    }
    if (done) {
      scene->gaussians =
          CountGaussians(context.workspace / "reconstruct" / "point_cloud.ply")
              .value_or(0);
    }
    return need;
  }

  Status Run(pipeline::StageContext& context) override {
    const pipeline::ResourceMeter meter;
    FREEGS_ASSIGN_OR_RETURN(const TrainingScene scene,
                            ReadTrainingScene(context.workspace));
    FREEGS_ASSIGN_OR_RETURN(const splat::TrainerOptions training,
                            TrainingOptions(scene.photos.train));
    splat::TrainingImagesOptions image_options;
    image_options.max_side = options_.max_image_size;
    image_options.num_levels = 1;
    const double cache = options_.image_cache_gb * double{kGigabyte};
    const double holdout_cache =
        cache * HoldoutShareOfCache(CountPixels(scene.photos.train),
                                    CountPixels(scene.photos.holdout));
    image_options.max_bytes = static_cast<uint64_t>(holdout_cache);
    image_options.fetched_in_order = true;
    FREEGS_ASSIGN_OR_RETURN(
        std::optional<splat::TrainingImages> holdout,
        LoadHoldout(scene, image_options, *context.pool, context.cancellation));
    image_options.max_bytes = static_cast<uint64_t>(cache - holdout_cache);
    image_options.fetched_in_order = false;

    const splat::ModelFrame& frame = scene.photos.frame;
    TrainedModel trained;
    splat::PlacedModel world;
    if (options_.import.empty()) {
      image_options.num_levels = 4;
      FREEGS_ASSIGN_OR_RETURN(splat::TrainingImages images,
                              LoadPhotos(scene,
                                         scene.photos.train,
                                         image_options,
                                         *context.pool,
                                         context.cancellation));
      FREEGS_ASSIGN_OR_RETURN(
          trained,
          TrainModel(options_, training, scene, &images, &holdout, context));
      // So that the model that is measured is the one that later stages read.
      splat::RoundToGrid(&trained.model);
      world = splat::ToWorld(trained.model, frame);
    } else {
      FREEGS_ASSIGN_OR_RETURN(world, ReadTrainedModel(options_.import, frame));
      if (options_.antialiased) world.model.antialiased = true;
      trained.model = splat::ToFrame(world, frame);
      context.log(pipeline::LogLevel::kInfo,
                  "imported " + std::to_string(trained.model.size()) +
                      " Gaussians from " + options_.import);
    }
    FREEGS_RETURN_IF_ERROR(CheckVisible(
        trained.model, scene.photos.train, training.render, *context.pool));
    const std::string note = FarAwayNote(frame);
    if (!note.empty()) {
      context.log(pipeline::LogLevel::kWarning, note);
    }
    FREEGS_RETURN_IF_ERROR(splat::WritePly(
        context.output / "point_cloud.ply", world.model, world.offset));
    if (!trained.exposures.empty()) {
      FREEGS_RETURN_IF_ERROR(
          WriteExposures(context.output / "exposure.json", trained.exposures));
    }
    nlohmann::json new_views = nlohmann::json::object();
    if (holdout) {
      FREEGS_ASSIGN_OR_RETURN(
          new_views,
          MeasureNewViews(trained, scene.photos, &*holdout, context));
      FREEGS_RETURN_IF_ERROR(CompareWithTrained(
          trained, scene, image_options, context, &new_views));
    }
    return WriteMetrics(trained, new_views, meter, context);
  }

 private:
  StatusOr<splat::TrainerOptions> TrainingOptions(
      std::span<const View> train) const {
    return MakeTrainerOptions(
        options_, CountPixels(train), pipeline::Memory().total_bytes, seed_);
  }

  // Counts pixels at the size of training.
  int64_t CountPixels(std::span<const View> views) const {
    return pipeline::CountPixels(views, options_.max_image_size).total;
  }

  // Measures what was trained on the holdout photos, and writes what it shows
  // there to holdout/. Returns the figures for metrics.json.
  StatusOr<nlohmann::json> MeasureNewViews(
      const TrainedModel& trained,
      const PosedPhotos& photos,
      splat::TrainingImages* holdout,
      pipeline::StageContext& context) const {
    nlohmann::json metrics = nlohmann::json::object();
    const splat::HoldoutTask task = {
        .model = trained.model,
        .render = ReconstructRenderOptions(options_),
        .images = holdout,
        .exposures = trained.exposures,
        .cancellation = context.cancellation};
    std::vector<View> views = photos.train;
    views.insert(views.end(), photos.holdout.begin(), photos.holdout.end());
    FREEGS_ASSIGN_OR_RETURN(const auto files, OutputNameByView(views, ".png"));
    FREEGS_ASSIGN_OR_RETURN(const splat::HoldoutReport quality,
                            splat::MeasureHoldout(task, *context.pool));
    if (quality.views.empty()) {
      context.log(pipeline::LogLevel::kWarning,
                  "masks leave nothing of any holdout photo, so "
                  "new views are not measured");
      return metrics;
    }
    metrics["holdout_psnr"] = quality.mean_psnr;
    metrics["holdout_ssim"] = quality.mean_ssim;
    metrics["holdout_tile_pairs"] = quality.tile_pairs;
    std::vector<DisplacedView> displaced;
    for (const splat::HoldoutView& view : quality.views) {
      metrics["holdout_views"].push_back(
          {{"name", view.name},
           {"psnr", view.psnr},
           {"ssim", view.ssim},
           {"displacement_px", view.displacement_px}});
      displaced.push_back(
          {view.displacement_px,
           std::max(view.rendered.width(), view.rendered.height())});
      if (IsCancelled(context.cancellation)) {
        return InterruptedError("stopped while writing renders of new views");
      }
      const fs::path file = context.output / "holdout" / files.at(view.name);
      FREEGS_RETURN_IF_ERROR(CreateFolders(file.parent_path()));
      FREEGS_RETURN_IF_ERROR(WriteImage(file, view.rendered));
    }
    FREEGS_ASSIGN_OR_RETURN(const std::optional<splat::FittedPsnr> right_halves,
                            splat::MeasureFittedHoldout(task, *context.pool));
    if (right_halves) {
      metrics["holdout_psnr_fitted"] = right_halves->fitted;
    }
    const std::string note =
        DisplacementNote(displaced, !options_.import.empty());
    if (!note.empty()) {
      context.log(pipeline::LogLevel::kWarning, note);
    }
    return metrics;
  }

  // Adds to the figures of new views how well a few of the photos are shown
  // that were trained on, and warns when new views are far worse.
  Status CompareWithTrained(const TrainedModel& trained,
                            const TrainingScene& scene,
                            splat::TrainingImagesOptions image_options,
                            pipeline::StageContext& context,
                            nlohmann::json* metrics) const {
    if (!metrics->contains("holdout_views")) return Status();
    constexpr size_t kPhotos = 8;
    const std::vector<View>& train = scene.photos.train;
    const size_t count = std::min(kPhotos, train.size());
    std::vector<View> some;
    for (size_t k = 0; k < count; ++k) {
      some.push_back(train[(2 * k + 1) * train.size() / (2 * count)]);
    }
    image_options.num_levels = 1;
    FREEGS_ASSIGN_OR_RETURN(
        splat::TrainingImages images,
        LoadPhotos(scene, some, image_options, *context.pool));
    FREEGS_ASSIGN_OR_RETURN(
        const std::optional<double> psnr,
        splat::MeasureHoldoutPsnr({.model = trained.model,
                                   .render = ReconstructRenderOptions(options_),
                                   .images = &images,
                                   .exposures = trained.exposures,
                                   .cancellation = context.cancellation},
                                  *context.pool));
    if (!psnr) return Status();
    (*metrics)["trained_psnr"] = *psnr;
    std::vector<double> holdout;
    for (const nlohmann::json& view : metrics->at("holdout_views")) {
      holdout.push_back(view["psnr"]);
    }
    const std::string note = NewViewsNote(*psnr, holdout);
    if (!note.empty()) {
      context.log(pipeline::LogLevel::kWarning, note);
    }
    return Status();
  }

  // `new_views`: figures of the holdout photos; an empty object without any.
  Status WriteMetrics(const TrainedModel& trained,
                      const nlohmann::json& new_views,
                      const pipeline::ResourceMeter& meter,
                      pipeline::StageContext& context) const {
    const splat::GaussianModel& model = trained.model;
    nlohmann::json metrics = {{"holdout_psnr", nullptr},
                              {"holdout_ssim", nullptr},
                              {"holdout_psnr_fitted", nullptr},
                              {"trained_psnr", nullptr},
                              {"holdout_tile_pairs", nullptr},
                              {"num_gaussians", model.size()},
                              {"sh_degree", model.sh_degree},
                              {"iterations", trained.iterations}};
    metrics.update(trained.course);
    metrics.update(new_views);
    const pipeline::ResourceUsage usage = meter.Elapsed();
    metrics["seconds"] = context.earlier_seconds + usage.wall_seconds;
    metrics["cpu_seconds"] = context.earlier_cpu_seconds + usage.cpu_seconds;
    metrics["peak_memory_bytes"] = usage.peak_memory_bytes;
    context.summary = metrics;
    context.summary.erase("holdout_views");
    context.summary.erase("milestones");
    return WriteFileAtomic(context.output / "metrics.json",
                           JsonText(metrics, 1));
  }

  ReconstructStageOptions options_;
  uint64_t seed_;
};

}  // namespace

std::unique_ptr<pipeline::Stage> MakeReconstructStage(
    const ReconstructStageOptions& options, uint64_t seed) {
  return std::make_unique<ReconstructStage>(options, seed);
}

}  // namespace freegs::stages
