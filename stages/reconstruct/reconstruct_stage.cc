// SPDX-License-Identifier: BSD-3-Clause

#include "stages/reconstruct/reconstruct_stage.h"

#include <algorithm>
#include <chrono>
#include <optional>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/io/files.h"
#include "core/io/image_io.h"
#include "pipeline/resource_usage.h"
#include "splat/images/holdout.h"
#include "splat/scene/ply_io.h"
#include "splat/images/resolution_schedule.h"
#include "splat/search/budget_search.h"
#include "splat/train/trainer.h"
#include "stages/reconstruct/progress_csv.h"
#include "stages/reconstruct/training_report.h"
#include "stages/scene/training_scene.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;

class ReconstructStage : public pipeline::Stage {
 public:
  ReconstructStage(const ReconstructStageOptions& options, uint64_t seed)
      : options_(options), seed_(seed) {}

  std::string_view name() const override { return "reconstruct"; }

  std::vector<fs::path> Inputs(const pipeline::StageContext&) const override {
    std::vector<fs::path> inputs = {
        "undistort/images", "undistort/sparse", "ingest/images.json"};
    if (!options_.import.empty()) inputs.emplace_back(options_.import);
    return inputs;
  }

  Status Run(pipeline::StageContext& context) override {
    const pipeline::ResourceMeter meter;
    FREEGS_ASSIGN_OR_RETURN(splat::TrainerOptions training,
                            MakeTrainerOptions(options_, seed_));
    const StatusOr<TrainingScene> read = ReadTrainingScene(context.workspace);
    if (!read.ok()) return read.status().Annotated("reconstruct");
    const TrainingScene& scene = *read;
    splat::TrainingImagesOptions image_options;
    image_options.max_side = options_.max_image_size;
    image_options.num_levels = 2;
    std::optional<splat::TrainingImages> holdout;
    if (!scene.photos.holdout.empty()) {
      FREEGS_ASSIGN_OR_RETURN(
          holdout, LoadHoldoutPhotos(scene, image_options, *context.pool));
    }
    splat::TrainingImages* holdout_images = holdout ? &*holdout : nullptr;

    splat::GaussianModel model;
    Outcome outcome;
    if (options_.import.empty()) {
      image_options.num_levels = 4;
      image_options.max_bytes =
          static_cast<uint64_t>(options_.image_cache_gb * 1e9);
      FREEGS_ASSIGN_OR_RETURN(
          splat::TrainingImages images,
          LoadTrainingPhotos(scene, image_options, *context.pool));
      FREEGS_ASSIGN_OR_RETURN(
          model,
          Train(training, scene, &images, holdout_images, context, &outcome));
    } else {
      FREEGS_ASSIGN_OR_RETURN(model, splat::ReadPly(options_.import));
      context.log(pipeline::LogLevel::kInfo,
                  "reconstruct: imported " + std::to_string(model.size()) +
                      " Gaussians from " + options_.import);
    }
    FREEGS_RETURN_IF_ERROR(
        splat::WritePly(context.output / "point_cloud.ply", model));
    return WriteMetrics(model, holdout_images, meter, outcome, context);
  }

 private:
  // What earlier, interrupted runs and this one's training add up to.
  struct Outcome {
    int64_t iterations = 0;
    double earlier_cpu_seconds = 0;
    double earlier_seconds = 0;
    nlohmann::json course = CourseJson("", nullptr);
  };

  StatusOr<splat::GaussianModel> Train(const splat::TrainerOptions& training,
                                       const TrainingScene& scene,
                                       splat::TrainingImages* images,
                                       splat::TrainingImages* holdout,
                                       pipeline::StageContext& context,
                                       Outcome* outcome) const {
    FREEGS_ASSIGN_OR_RETURN(splat::GaussianModel initial, InitialModel(scene));
    splat::TrainerOptions options = training;
    if (options_.coarse_to_fine) {
      FREEGS_ASSIGN_OR_RETURN(options.schedule.resolution_steps,
                              splat::SpectrumResolutionSteps(images));
    }
    splat::Trainer trainer(
        options, std::move(initial), scene.extent, images, context.pool);

    const fs::path checkpoints = context.output / "checkpoints";
    FREEGS_RETURN_IF_ERROR(CreateFolders(checkpoints));
    if (context.resuming) {
      FREEGS_RETURN_IF_ERROR(Resume(checkpoints, context, &trainer, outcome));
    }
    ProgressCsv progress(context.output / "progress.csv");
    FREEGS_RETURN_IF_ERROR(progress.Open(trainer.iteration()));

    const pipeline::ResourceMeter meter;
    auto last_checkpoint = std::chrono::steady_clock::now();
    const auto save = [&]() -> Status {
      splat::TrainingCheckpoint checkpoint = trainer.Save();
      checkpoint.elapsed_seconds =
          outcome->earlier_seconds + meter.Elapsed().wall_seconds;
      checkpoint.facts["cpu_seconds"] = std::to_string(
          outcome->earlier_cpu_seconds + meter.Elapsed().cpu_seconds);
      FREEGS_RETURN_IF_ERROR(progress.Flush());
      last_checkpoint = std::chrono::steady_clock::now();
      return splat::SaveCheckpoint(checkpoints, checkpoint);
    };
    if (SearchesBudget(options, holdout) && trainer.iteration() == 0) {
      FREEGS_ASSIGN_OR_RETURN(splat::BudgetChoice choice,
                              splat::SearchBudget({},
                                                  options,
                                                  trainer.model(),
                                                  scene.extent,
                                                  Judge(holdout, context),
                                                  images,
                                                  context.pool,
                                                  context.cancellation));
      trainer.KeepTo(std::move(choice));
    }
    double loss_sum = 0;
    int loss_count = 0;
    while (!trainer.done()) {
      if (context.cancellation->cancelled()) {
        FREEGS_RETURN_IF_ERROR(save());
        return InterruptedError("reconstruct: stopped at iteration " +
                                std::to_string(trainer.iteration()) +
                                "; the checkpoint is saved");
      }
      FREEGS_ASSIGN_OR_RETURN(const splat::StepReport report, trainer.Step());
      if (report.recovered) {
        // Rows beyond the state gone back to are of another course.
        context.log(
            pipeline::LogLevel::kWarning,
            "reconstruct: " + RecoveryText(trainer.recoveries().back()));
        FREEGS_RETURN_IF_ERROR(progress.Flush());
        FREEGS_RETURN_IF_ERROR(progress.Open(trainer.iteration()));
        loss_sum = 0;
        loss_count = 0;
        continue;
      }
      LogMilestone(report, trainer, context);
      loss_sum += report.loss;
      ++loss_count;
      const bool measure = holdout != nullptr && !trainer.done() &&
                           options_.holdout_interval > 0 &&
                           report.iteration % options_.holdout_interval == 0;
      if (report.iteration % kProgressInterval == 0 || measure ||
          trainer.done()) {
        std::optional<double> psnr;
        if (measure) {
          FREEGS_ASSIGN_OR_RETURN(
              const splat::HoldoutReport quality,
              splat::MeasureHoldout(trainer.model(),
                                    ReconstructRenderOptions(options_),
                                    holdout,
                                    *context.pool));
          psnr = quality.mean_psnr;
        }
        const double loss = loss_sum / loss_count;
        progress.Add({report.iteration,
                      outcome->earlier_seconds + meter.Elapsed().wall_seconds,
                      loss,
                      report.num_gaussians,
                      psnr});
        ReportProgress(report, loss, context);
        loss_sum = 0;
        loss_count = 0;
      }
      const std::chrono::duration<double> since =
          std::chrono::steady_clock::now() - last_checkpoint;
      if (since.count() >= context.checkpoint_interval_seconds) {
        FREEGS_RETURN_IF_ERROR(save());
      }
    }
    FREEGS_RETURN_IF_ERROR(save());
    outcome->iterations = trainer.iteration();
    outcome->course = CourseJson(options_.densification, &trainer);
    return trainer.model();
  }

  // Whether the number of Gaussians is to be found out: the option asks for it,
  // and there are photographs to judge by.
  bool SearchesBudget(const splat::TrainerOptions& training,
                      const splat::TrainingImages* holdout) const {
    return options_.budget == "auto" && holdout != nullptr &&
           training.schedule.method ==
               splat::DensificationMethod::kMiniSplatting;
  }

  // What the search for a budget goes by.
  splat::QualityJudge Judge(splat::TrainingImages* holdout,
                            pipeline::StageContext& context) const {
    return [this, holdout, &context](const splat::GaussianModel& model,
                                     int level) -> StatusOr<double> {
      FREEGS_ASSIGN_OR_RETURN(
          const splat::HoldoutReport quality,
          splat::MeasureHoldout(model,
                                ReconstructRenderOptions(options_),
                                holdout,
                                *context.pool,
                                level));
      context.log(pipeline::LogLevel::kInfo,
                  "reconstruct: " + TrialText(model, quality.mean_psnr, level));
      return quality.mean_psnr;
    };
  }

  static Status Resume(const fs::path& checkpoints,
                       pipeline::StageContext& context,
                       splat::Trainer* trainer,
                       Outcome* outcome) {
    std::vector<std::string> problems;
    std::optional<splat::TrainingCheckpoint> checkpoint =
        splat::LatestCheckpoint(checkpoints, &problems);
    for (const std::string& problem : problems) {
      context.log(pipeline::LogLevel::kWarning, problem);
    }
    if (!checkpoint) return Status();
    outcome->earlier_seconds = checkpoint->elapsed_seconds;
    const auto cpu = checkpoint->facts.find("cpu_seconds");
    if (cpu != checkpoint->facts.end()) {
      outcome->earlier_cpu_seconds = std::strtod(cpu->second.c_str(), nullptr);
    }
    context.log(pipeline::LogLevel::kInfo,
                "reconstruct: resuming at iteration " +
                    std::to_string(checkpoint->iteration));
    return trainer->Restore(*std::move(checkpoint));
  }

  // When the step just done was the last before one.
  static void LogMilestone(const splat::StepReport& report,
                           const splat::Trainer& trainer,
                           pipeline::StageContext& context) {
    if (trainer.milestones().empty()) return;
    const splat::MilestoneRecord& record = trainer.milestones().back();
    if (record.iteration != report.iteration) return;
    context.log(pipeline::LogLevel::kInfo,
                "reconstruct: " + MilestoneText(record));
  }

  void ReportProgress(const splat::StepReport& report,
                      double loss,
                      pipeline::StageContext& context) const {
    char detail[96];
    std::snprintf(detail,
                  sizeof(detail),
                  "loss %.4f, %zu Gaussians",
                  loss,
                  report.num_gaussians);
    context.progress({"training",
                      static_cast<double>(report.iteration),
                      static_cast<double>(options_.iterations),
                      detail});
  }

  Status WriteMetrics(const splat::GaussianModel& model,
                      splat::TrainingImages* holdout,
                      const pipeline::ResourceMeter& meter,
                      const Outcome& outcome,
                      pipeline::StageContext& context) const {
    nlohmann::json metrics = {{"holdout_psnr", nullptr},
                              {"holdout_ssim", nullptr},
                              {"num_gaussians", model.size()},
                              {"sh_degree", model.sh_degree},
                              {"iterations", outcome.iterations}};
    metrics.update(outcome.course);
    if (holdout != nullptr) {
      FREEGS_ASSIGN_OR_RETURN(
          const splat::HoldoutReport quality,
          splat::MeasureHoldout(model,
                                ReconstructRenderOptions(options_),
                                holdout,
                                *context.pool));
      metrics["holdout_psnr"] = quality.mean_psnr;
      metrics["holdout_ssim"] = quality.mean_ssim;
      nlohmann::json& views = metrics["holdout_views"];
      for (const splat::HoldoutView& view : quality.views) {
        views.push_back(
            {{"name", view.name}, {"psnr", view.psnr}, {"ssim", view.ssim}});
        const fs::path file =
            (context.output / "holdout" / view.name).replace_extension(".png");
        FREEGS_RETURN_IF_ERROR(CreateFolders(file.parent_path()));
        FREEGS_RETURN_IF_ERROR(WriteImage(file, view.rendered));
      }
    }
    const pipeline::ResourceUsage usage = meter.Elapsed();
    metrics["seconds"] = outcome.earlier_seconds + usage.wall_seconds;
    metrics["cpu_seconds"] = outcome.earlier_cpu_seconds + usage.cpu_seconds;
    metrics["peak_memory_bytes"] = usage.peak_memory_bytes;
    context.summary = metrics;
    context.summary.erase("holdout_views");
    context.summary.erase("milestones");
    if (!context.summary["budget_search"].is_null()) {
      context.summary["budget_search"].erase("trials");
    }
    return WriteFileAtomic(context.output / "metrics.json",
                           metrics.dump(1) + "\n");
  }

  static constexpr int64_t kProgressInterval = 50;

  ReconstructStageOptions options_;
  uint64_t seed_;
};

}  // namespace

std::unique_ptr<pipeline::Stage> MakeReconstructStage(
    const ReconstructStageOptions& options, uint64_t seed) {
  return std::make_unique<ReconstructStage>(options, seed);
}

}  // namespace freegs::stages
