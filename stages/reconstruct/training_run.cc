// SPDX-License-Identifier: BSD-3-Clause

#include "stages/reconstruct/training_run.h"

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/cancellation.h"
#include "core/io/files.h"
#include "pipeline/resource_usage.h"
#include "splat/images/holdout.h"
#include "splat/images/resolution_schedule.h"
#include "splat/search/exposure_search.h"
#include "splat/train/checkpoint.h"
#include "stages/reconstruct/progress_csv.h"
#include "stages/reconstruct/training_preview.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;
using pipeline::LogLevel;

constexpr int64_t kProgressInterval = 50;

// A training that has to end early makes so many steps all the same.
constexpr int64_t kLeastSteps = 300;

// A text from which strtod reads the same number.
std::string ExactText(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.17g", value);
  return text;
}

// A number that was saved with a checkpoint; 0 where an older program did not
// save it.
double Fact(const splat::TrainingCheckpoint& checkpoint,
            const std::string& name) {
  const auto fact = checkpoint.facts.find(name);
  if (fact == checkpoint.facts.end()) return 0;
  return std::strtod(fact->second.c_str(), nullptr);
}

// Drives a trainer from its first or its last saved step to the end.
class TrainingRun {
 public:
  TrainingRun(const ReconstructStageOptions& options,
              splat::Trainer* trainer,
              std::optional<splat::TrainingImages>* holdout,
              const View& preview_view,
              pipeline::StageContext* context)
      : options_(options),
        trainer_(trainer),
        holdout_(holdout),
        context_(context),
        checkpoints_(context->output / "checkpoints"),
        progress_(context->output / "progress.csv"),
        preview_({.file = context->preview},
                 preview_view,
                 ReconstructRenderOptions(options)) {}

  // Takes up what an interrupted run has left, if there is any.
  Status Begin() {
    FREEGS_RETURN_IF_ERROR(CreateFolders(checkpoints_));
    if (context_->resuming) FREEGS_RETURN_IF_ERROR(Resume());
    return progress_.Open(trainer_->iteration());
  }

  Status Train() {
    FREEGS_RETURN_IF_ERROR(FinishLastStep());
    while (!trainer_->done()) {
      if (TimeIsUp()) {
        FREEGS_ASSIGN_OR_RETURN(const bool went_back,
                                trainer_->GoBackUnlessFinite());
        if (went_back) {
          FREEGS_RETURN_IF_ERROR(ForgetWhatDiverged());
          continue;
        }
        context_->log(LogLevel::kWarning,
                      "the time is up; training ends after " +
                          std::to_string(trainer_->iteration()) + " of " +
                          std::to_string(options_.iterations) + " iterations");
        break;
      }
      if (IsCancelled(context_->cancellation)) return Stop();
      FREEGS_ASSIGN_OR_RETURN(const splat::StepReport report,
                              trainer_->Step(context_->cancellation));
      if (report.recovered) {
        FREEGS_RETURN_IF_ERROR(ForgetWhatDiverged());
        continue;
      }
      FREEGS_RETURN_IF_ERROR(Record(report));
      if (report.interrupted) return Stop();
      if (SecondsSinceCheckpoint() >= context_->checkpoint_interval_seconds) {
        FREEGS_RETURN_IF_ERROR(SaveCheckpoint());
      }
    }
    return SaveCheckpoint();
  }

  TrainedModel Result() const {
    return {.model = trainer_->model(),
            .iterations = trainer_->iteration(),
            .exposures = trainer_->Exposures(),
            .course = CourseJson(options_.densification, trainer_)};
  }

 private:
  Status Stop() {
    FREEGS_RETURN_IF_ERROR(SaveCheckpoint());
    return InterruptedError(
        "stopped at iteration " + std::to_string(trainer_->iteration()) +
        (SearchWasCut() ? "; training will start afresh, because the time "
                          "was up before exposure was decided about"
                        : "; the checkpoint is saved"));
  }

  Status Resume() {
    std::vector<std::string> problems;
    std::optional<splat::TrainingCheckpoint> checkpoint =
        splat::LatestCheckpoint(checkpoints_, &problems);
    for (const std::string& problem : problems) {
      context_->log(LogLevel::kWarning, problem);
    }
    if (!checkpoint) {
      if (!problems.empty()) {
        context_->log(LogLevel::kWarning,
                      "no checkpoint can be used: training starts afresh");
      }
      return Status();
    }
    earlier_seconds_ = checkpoint->elapsed_seconds;
    earlier_cpu_seconds_ = Fact(*checkpoint, "cpu_seconds");
    loss_sum_ = Fact(*checkpoint, "row_loss_sum");
    loss_count_ = Fact(*checkpoint, "row_loss_count");
    context_->log(
        LogLevel::kInfo,
        "resuming at iteration " + std::to_string(checkpoint->iteration));
    const fs::path file =
        splat::CheckpointPath(checkpoints_, checkpoint->iteration);
    return trainer_->Restore(*std::move(checkpoint)).Annotated(file.string());
  }

  // Whether there was no time to decide about exposure. Such a training is at
  // most kLeastSteps long and leaves no checkpoint: a resumed run, which may
  // have the time, searches and starts afresh, since exposure cannot begin to
  // be learnt in the middle.
  bool SearchWasCut() const {
    return options_.exposure == "auto" && !trainer_->exposure_choice();
  }

  Status SaveCheckpoint() {
    FREEGS_RETURN_IF_ERROR(progress_.Flush());
    last_checkpoint_ = std::chrono::steady_clock::now();
    if (SearchWasCut()) return Status();
    splat::TrainingCheckpointView checkpoint = trainer_->CheckpointView();
    const pipeline::ResourceUsage usage = meter_.Elapsed();
    checkpoint.elapsed_seconds = earlier_seconds_ + usage.wall_seconds;
    checkpoint.facts["cpu_seconds"] =
        std::to_string(earlier_cpu_seconds_ + usage.cpu_seconds);
    checkpoint.facts["row_loss_sum"] = ExactText(loss_sum_);
    checkpoint.facts["row_loss_count"] = ExactText(loss_count_);
    return splat::SaveCheckpoint(checkpoints_, checkpoint);
  }

  bool TimeIsUp() const {
    return context_->deadline && trainer_->iteration() >= kLeastSteps &&
           std::chrono::steady_clock::now() >= *context_->deadline;
  }

  double SecondsSinceCheckpoint() const {
    const std::chrono::duration<double> since =
        std::chrono::steady_clock::now() - last_checkpoint_;
    return since.count();
  }

  // The trainer has gone back to an earlier state. The rows of progress.csv
  // beyond that state, and the losses since the last row, tell of steps that no
  // longer count.
  Status ForgetWhatDiverged() {
    context_->log(LogLevel::kWarning,
                  RecoveryText(trainer_->recoveries().back()));
    loss_sum_ = 0;
    loss_count_ = 0;
    FREEGS_RETURN_IF_ERROR(progress_.Flush());
    return progress_.Open(trainer_->iteration());
  }

  bool MeasurementIsDue() const {
    return *holdout_ && !trainer_->done() && options_.holdout_interval > 0 &&
           trainer_->iteration() % options_.holdout_interval == 0;
  }

  // At every kProgressInterval-th step, every measurement and the last step.
  bool RowIsDue() const {
    return trainer_->iteration() % kProgressInterval == 0 ||
           MeasurementIsDue() || trainer_->done();
  }

  // Logs the step's milestone, and adds a row to progress.csv if it is due.
  Status Record(const splat::StepReport& report) {
    loss_sum_ += report.loss;
    ++loss_count_;
    if (report.interrupted) return Status();  // FinishLastStep does the rest.
    LogMilestone();
    return RowIsDue() ? AddRow() : Status();
  }

  // Makes up for what was interrupted after the last step of an earlier run.
  // Where a row was added, no losses are left.
  Status FinishLastStep() {
    FREEGS_ASSIGN_OR_RETURN(const bool milestone,
                            trainer_->FinishMilestone(context_->cancellation));
    if (milestone) LogMilestone();
    return loss_count_ > 0 && RowIsDue() ? AddRow() : Status();
  }

  // When the measurement is cancelled, the row stays away and the losses are
  // kept. They are saved with the checkpoint, so that the run that goes on from
  // there can add the row (FinishLastStep).
  Status AddRow() {
    std::optional<double> psnr;
    if (MeasurementIsDue()) {
      const StatusOr<std::optional<double>> measured = HoldoutPsnr();
      if (measured.status().code() == StatusCode::kInterrupted) return Status();
      FREEGS_ASSIGN_OR_RETURN(psnr, measured);
    }
    const double loss = loss_sum_ / loss_count_;
    loss_sum_ = 0;
    loss_count_ = 0;
    progress_.Add({trainer_->iteration(),
                   earlier_seconds_ + meter_.Elapsed().wall_seconds,
                   loss,
                   trainer_->model().size(),
                   psnr});
    ShowProgress(loss);
    if (preview_.Due()) {
      // Those who look on see the curve grow, too. Rows beyond the checkpoint
      // are dropped when the training goes on from there.
      preview_.Write(trainer_->model(), *context_->pool, [this] {
        (void)progress_.Flush();
      });
    }
    return Status();
  }

  // Mean PSNR in dB over the holdout photos; nothing if masks leave none.
  // kInterrupted when cancelled.
  StatusOr<std::optional<double>> HoldoutPsnr() {
    return splat::MeasureHoldoutPsnr(
        {.model = trainer_->model(),
         .render = ReconstructRenderOptions(options_),
         .images = &**holdout_,
         .exposures = trainer_->Exposures(),
         .cancellation = context_->cancellation},
        *context_->pool);
  }

  // Does nothing for a step that ended at no milestone.
  void LogMilestone() const {
    if (trainer_->milestones().empty()) return;
    const splat::MilestoneRecord& record = trainer_->milestones().back();
    if (record.iteration != trainer_->iteration()) return;
    context_->log(LogLevel::kInfo, MilestoneText(record));
  }

  void ShowProgress(double loss) const {
    char detail[96];
    std::snprintf(detail,
                  sizeof(detail),
                  "loss %.4f, %zu Gaussians",
                  loss,
                  trainer_->model().size());
    context_->progress({"training",
                        static_cast<double>(trainer_->iteration()),
                        static_cast<double>(options_.iterations),
                        detail});
  }

  const ReconstructStageOptions& options_;
  splat::Trainer* trainer_;
  std::optional<splat::TrainingImages>* holdout_;
  pipeline::StageContext* context_;
  fs::path checkpoints_;
  ProgressCsv progress_;
  TrainingPreview preview_;
  pipeline::ResourceMeter meter_;
  std::chrono::steady_clock::time_point last_checkpoint_ =
      std::chrono::steady_clock::now();
  double earlier_seconds_ = 0;
  double earlier_cpu_seconds_ = 0;

  // The sum of the losses, and how many they are, since the last row of
  // progress.csv.
  double loss_sum_ = 0;
  double loss_count_ = 0;
};

}  // namespace

StatusOr<TrainedModel> TrainModel(const ReconstructStageOptions& options,
                                  const splat::TrainerOptions& training,
                                  const TrainingScene& scene,
                                  splat::TrainingImages* images,
                                  std::optional<splat::TrainingImages>* holdout,
                                  pipeline::StageContext& context) {
  FREEGS_ASSIGN_OR_RETURN(splat::GaussianModel initial, InitialModel(scene));
  splat::TrainerOptions trainer_options = training;
  FREEGS_ASSIGN_OR_RETURN(trainer_options.schedule.resolution_steps,
                          splat::SpectrumResolutionSteps(images));
  splat::Trainer trainer(
      trainer_options, std::move(initial), scene.extent, images, *context.pool);
  const std::vector<View>& views = scene.photos.train;
  TrainingRun run(
      options, &trainer, holdout, views[views.size() / 2], &context);
  FREEGS_RETURN_IF_ERROR(run.Begin());
  // A checkpoint carries the choice of an earlier search, so that a resumed
  // training needs no search of its own.
  if (options.exposure == "auto" && !trainer.exposure_choice()) {
    FREEGS_ASSIGN_OR_RETURN(
        const std::optional<splat::ExposureChoice> choice,
        splat::SearchExposure({.deadline = context.deadline},
                              trainer_options,
                              {trainer.model(), scene.extent, images},
                              *context.pool,
                              context.cancellation,
                              context.progress));
    context.log(LogLevel::kInfo, ExposureText(choice));
    if (choice) trainer.SetExposureChoice(*choice);
  }
  FREEGS_RETURN_IF_ERROR(run.Train());
  return run.Result();
}

}  // namespace freegs::stages
