// SPDX-License-Identifier: BSD-3-Clause

#include <cstdint>
#include <cstdio>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bench/training_modes.h"
#include "pipeline/resource_usage.h"
#include "pipeline/system_info.h"
#include "splat/images/holdout.h"
#include "splat/images/resolution_schedule.h"
#include "splat/search/exposure_search.h"
#include "splat/train/trainer.h"
#include "stages/reconstruct/reconstruct_options.h"
#include "stages/reconstruct/training_report.h"
#include "stages/reconstruct/training_run.h"
#include "stages/registry/pipeline_options.h"
#include "stages/scene/training_scene.h"

namespace freegs::bench {
namespace {

// Time spent since construction, without what was spent between Stop and Start.
class TrainingClock {
 public:
  void Stop() { stopped_ = meter_.Elapsed(); }
  void Start() {
    const pipeline::ResourceUsage now = meter_.Elapsed();
    left_out_seconds_ += now.wall_seconds - stopped_.wall_seconds;
    left_out_cpu_seconds_ += now.cpu_seconds - stopped_.cpu_seconds;
  }

  // While stopped.
  double seconds() const { return stopped_.wall_seconds - left_out_seconds_; }
  double cpu_seconds() const {
    return stopped_.cpu_seconds - left_out_cpu_seconds_;
  }

 private:
  pipeline::ResourceMeter meter_{pipeline::PeakMemory::kReset};
  pipeline::ResourceUsage stopped_;
  double left_out_seconds_ = 0;
  double left_out_cpu_seconds_ = 0;
};

// Preset, WORKSPACE/config.ini and command line, as the pipeline reads them.
Status ReadSettings(const CurveOptions& options,
                    stages::PipelineOptions* pipeline_options) {
  const std::string source = "command line";
  std::vector<pipeline::OptionSetting> settings;
  if (options.preset) {
    settings.push_back({"general.preset", *options.preset, source});
  }
  if (options.threads) {
    settings.push_back(
        {"general.threads", std::to_string(*options.threads), source});
  }
  if (options.max_image_size) {
    settings.push_back({"reconstruct.max_image_size",
                        std::to_string(*options.max_image_size),
                        source});
  }
  for (const std::string& setting : options.settings) {
    const size_t equals = setting.find('=');
    if (equals == std::string::npos) {
      return InvalidArgumentError("--set " + setting +
                                  ": not of the form SECTION.KEY=VALUE");
    }
    settings.push_back(
        {setting.substr(0, equals), setting.substr(equals + 1), source});
  }
  pipeline::OptionTable table = stages::MakeOptionTable(pipeline_options);
  FREEGS_RETURN_IF_ERROR(
      stages::ApplySettings(options.workspace, settings, table));
  if (!pipeline_options->reconstruct.import.empty()) {
    return InvalidArgumentError("reconstruct.import leaves nothing to train");
  }
  return Status();
}

void ReportCourse(const splat::Trainer& trainer) {
  for (const splat::MilestoneRecord& record : trainer.milestones()) {
    std::fprintf(stderr, "%s\n", stages::MilestoneText(record).c_str());
  }
  for (const splat::Recovery& recovery : trainer.recoveries()) {
    std::fprintf(stderr, "%s\n", stages::RecoveryText(recovery).c_str());
  }
}

// Trains to the end, or until the holdout photos have the PSNR that is asked
// for, which the result tells. Prints their quality after every so many steps.
StatusOr<bool> TrainAndMeasure(const CurveOptions& options,
                               const splat::RenderOptions& render,
                               splat::TrainingImages* holdout,
                               ThreadPool& pool,
                               TrainingClock* clock,
                               splat::Trainer* trainer) {
  std::printf(
      "iteration,seconds,cpu_seconds,gaussians,holdout_psnr,holdout_ssim\n");
  bool reached = false;
  while (!trainer->done() && !reached) {
    FREEGS_ASSIGN_OR_RETURN(const splat::StepReport report, trainer->Step());
    if (report.recovered) continue;
    if (report.iteration % options.every != 0 && !trainer->done()) continue;
    clock->Stop();
    FREEGS_ASSIGN_OR_RETURN(
        const splat::HoldoutReport quality,
        splat::MeasureHoldout({.model = trainer->model(),
                               .render = render,
                               .images = holdout,
                               .exposures = trainer->Exposures()},
                              pool));
    std::printf("%lld,%.3f,%.3f,%zu,%.3f,%.4f\n",
                static_cast<long long>(report.iteration),
                clock->seconds(),
                clock->cpu_seconds(),
                report.num_gaussians,
                quality.mean_psnr,
                quality.mean_ssim);
    std::fflush(stdout);
    reached = options.until && quality.mean_psnr >= *options.until;
    if (!reached && !trainer->done()) clock->Start();
  }
  return reached;
}

}  // namespace

// The clock runs from the photos being in memory on: the first Gaussians, the
// choice of resolutions and the search about exposure count.
Status RunCurve(const CurveOptions& options) {
  stages::PipelineOptions pipeline_options;
  FREEGS_RETURN_IF_ERROR(ReadSettings(options, &pipeline_options));
  const stages::ReconstructStageOptions& reconstruct =
      pipeline_options.reconstruct;
  FREEGS_ASSIGN_OR_RETURN(const stages::TrainingScene scene,
                          stages::ReadTrainingScene(options.workspace));
  FREEGS_ASSIGN_OR_RETURN(
      splat::TrainerOptions training,
      stages::MakeTrainerOptions(
          reconstruct,
          pipeline::CountPixels(scene.photos.train, reconstruct.max_image_size)
              .total,
          pipeline::Memory().total_bytes,
          static_cast<uint64_t>(pipeline_options.general.seed)));
  ThreadPool pool(pipeline_options.general.threads);
  splat::TrainingImagesOptions image_options;
  image_options.max_side = reconstruct.max_image_size;
  image_options.num_levels = 1;
  FREEGS_ASSIGN_OR_RETURN(std::optional<splat::TrainingImages> holdout,
                          stages::LoadHoldout(scene, image_options, pool));
  if (!holdout) return NoHoldoutError();
  image_options.num_levels = 4;
  image_options.max_bytes =
      static_cast<uint64_t>(reconstruct.image_cache_gb * 1e9);
  FREEGS_ASSIGN_OR_RETURN(
      splat::TrainingImages images,
      stages::LoadPhotos(scene, scene.photos.train, image_options, pool));

  TrainingClock clock;
  FREEGS_ASSIGN_OR_RETURN(splat::GaussianModel initial,
                          stages::InitialModel(scene));
  FREEGS_ASSIGN_OR_RETURN(training.schedule.resolution_steps,
                          splat::SpectrumResolutionSteps(&images));
  splat::Trainer trainer(
      training, std::move(initial), scene.extent, &images, pool);
  if (reconstruct.exposure == "auto") {
    FREEGS_ASSIGN_OR_RETURN(
        const std::optional<splat::ExposureChoice> choice,
        splat::SearchExposure({},
                              training,
                              {trainer.model(), scene.extent, &images},
                              pool,
                              /*cancellation=*/nullptr));
    std::fprintf(stderr, "%s\n", stages::ExposureText(choice).c_str());
    trainer.SetExposureChoice(*choice);  // There is one: no deadline is set.
  }
  FREEGS_ASSIGN_OR_RETURN(
      const bool reached,
      TrainAndMeasure(options,
                      stages::ReconstructRenderOptions(reconstruct),
                      &*holdout,
                      pool,
                      &clock,
                      &trainer));
  ReportCourse(trainer);
  if (options.until) {
    std::printf("%s %g dB at %.3f s\n",
                reached ? "reached" : "not reached",
                *options.until,
                clock.seconds());
  }
  return Status();
}

}  // namespace freegs::bench
