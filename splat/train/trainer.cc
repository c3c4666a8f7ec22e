// SPDX-License-Identifier: BSD-3-Clause

#include "splat/train/trainer.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <utility>

#include "core/text.h"
#include "splat/images/ignored_pixels.h"
#include "splat/scene/spatial_order.h"

namespace freegs::splat {
namespace {

// All parameters are checked for NaN and infinity after so many iterations.
constexpr int64_t kFiniteTestInterval = 100;

// Why a training goes back to its last good state.
constexpr char kNotFinite[] = "a parameter is not a finite number";

// A return to the last good state multiplies the learning rates by this.
constexpr double kRecoveryRateFactor = 0.5;

// The space around cameras is cleared until this share of the iterations.
constexpr double kClearShare = 0.9;

// The mean of the last steps takes the model after so many steps each.
constexpr int64_t kAverageInterval = 2;

DensificationOptions EffectiveDensification(const TrainerOptions& options) {
  DensificationOptions densification = options.densification;
  const bool mini =
      options.schedule.method == DensificationMethod::kMiniSplatting;
  densification.blur_split_share =
      mini ? options.mini_splatting.blur_split_share : 0;
  if (options.budget > 0) {
    const double factor = mini ? options.mini_splatting.dense_factor : 1;
    densification.max_gaussians = static_cast<int64_t>(
        std::llround(factor * static_cast<double>(options.budget)));
  }
  return densification;
}

std::vector<View> AllViews(const TrainingImages& images) {
  std::vector<View> views;
  for (size_t i = 0; i < images.size(); ++i) views.push_back(images.view(i));
  return views;
}

Status InitialNumbersError() {
  return UnusableResultError(
      "training: a parameter of the initial Gaussians is not a finite number");
}

}  // namespace

Status TrainerOptions::Check() const {
  // Rounded, and a few times as many, it must still be a number of Gaussians.
  if (budget < 0 || budget > int64_t{1} << 40) {
    return InvalidArgumentError("budget must be in 0 .. 2^40");
  }
  if (!(render.near_plane > 0 && std::isfinite(render.near_plane)) ||
      !(render.dilation >= 0 && std::isfinite(render.dilation)) ||
      render.sh_degree < 0) {
    return InvalidArgumentError(
        "render: near_plane must be positive, dilation and sh_degree not "
        "negative");
  }
  if (snapshot_interval < 1 || clear_interval < 1 || decay_interval < 1 ||
      max_recoveries < 0) {
    return InvalidArgumentError(
        "snapshot_interval, clear_interval and decay_interval must be "
        "positive, max_recoveries not negative");
  }
  if (!(average_from >= 0 && average_from <= 1)) {
    return InvalidArgumentError("average_from must be a share of the steps");
  }
  FREEGS_RETURN_IF_ERROR(opacity_decay.Check());
  FREEGS_RETURN_IF_ERROR(clearance.Check());
  FREEGS_RETURN_IF_ERROR(schedule.Check());
  FREEGS_RETURN_IF_ERROR(mini_splatting.Check());
  FREEGS_RETURN_IF_ERROR(densification.Check());
  FREEGS_RETURN_IF_ERROR(learning_rates.Check());
  FREEGS_RETURN_IF_ERROR(exposure.Check());
  return loss.Check();
}

Trainer::Trainer(const TrainerOptions& options,
                 GaussianModel initial_model,
                 double scene_extent,
                 TrainingImages* images,
                 ThreadPool& pool)
    : options_(options),
      densification_(EffectiveDensification(options)),
      schedule_(options.schedule),
      scene_extent_(scene_extent),
      images_(images),
      pool_(pool),
      importance_metric_(
          ChooseImportanceMetric(AllViews(*images), initial_model)),
      view_order_(options.seed, images->size()),
      model_(std::move(initial_model)),
      loss_monitor_(images->size()),
      loss_(options.loss) {
  if (options.schedule.method != DensificationMethod::kNone) {
    const double share =
        OpacityDecayShare(options.opacity_decay, images->size());
    decay_ = 1 - std::pow(1 - share, options.decay_interval);
    clear_balls_ =
        ClearBalls(options.clearance, AllViews(*images), model_, pool);
  }
  adam_.Reset(model_);
  statistics_.Reset(model_.size());
  model_.antialiased = options.antialiased;
  if (options.exposure.learn) history_.colors.entries.resize(images->size());
}

StatusOr<float> Trainer::GradientStep() {
  const size_t view_index = view_order_.ViewOf(iteration_);
  const int level =
      schedule_.ResolutionLevel(iteration_, images_->num_levels());
  const int sh_degree = schedule_.ShDegree(iteration_);
  if (model_.sh_degree < sh_degree) {
    model_.SetShDegree(sh_degree);
    adam_.SetShDegree(sh_degree);
    history_.average.Clear();
  }
  // The statistics are for the next densification, and the dominant Gaussians
  // for its blur splits. Steps that need neither do not compute them.
  const bool collect = schedule_.CollectsStatistics(iteration_);
  const bool dominant = collect && densification_.blur_split_share > 0;

  const Pinhole camera = images_->camera(view_index, level);
  FREEGS_RETURN_IF_ERROR(images_->Fetch(view_index, level, &target_));
  rasterizer_.Forward(model_,
                      camera,
                      images_->cam_from_world(view_index),
                      options_.render,
                      {.dominant = dominant},
                      pool_,
                      &rendered_);
  const float loss = LossOfView(view_index, level);
  LearningRates rates =
      LearningRatesAt(options_.learning_rates,
                      scene_extent_,
                      schedule_.PositionRateIteration(iteration_));
  for (float& rate : rates) rate *= static_cast<float>(history_.rate_factor);
  adam_.BeginStep(rates);
  std::atomic<bool> touched_finite = true;
  rasterizer_.BackwardInChunks(
      model_,
      {.color = &loss_gradient_},
      rendered_,
      pool_,
      [&](std::span<const uint32_t> visible, const GaussianGradients& rows) {
        adam_.UpdateRows(visible, rows, &model_);
        if (!BoundParameters(scene_extent_, visible, &model_)) {
          touched_finite = false;
        }
      });
  touched_finite_ = touched_finite;
  if (collect) {
    statistics_.AddView(rasterizer_.projection().visible,
                        rasterizer_.mean2d_gradients(),
                        camera.width,
                        camera.height,
                        pool_);
  }
  const ImageU8* const mask = images_->Mask(view_index, level);
  if (dominant && mask != nullptr) {
    FillIgnored(*mask, -1, &rendered_.dominant);
  }
  if (dominant) statistics_.AddDominant(rendered_.dominant, pool_);
  return loss;
}

// Compares rendered_ with target_, and writes dL/dcolor to loss_gradient_.
float Trainer::LossOfView(size_t view_index, int level) {
  PhotoColors& colors = history_.colors;
  const double share = static_cast<double>(iteration_) /
                       static_cast<double>(schedule_.iterations());
  const bool exposed =
      !colors.entries.empty() && share >= options_.exposure.start;
  const AffineColor color =
      exposed ? colors.entries[view_index].color : AffineColor();
  if (exposed) ApplyColor(color, rendered_.color, pool_, &exposed_);
  const ImageF& shown = exposed ? exposed_ : rendered_.color;
  // Where the mask says to ignore the photo, the rendering is right as it is.
  const ImageU8* const mask = images_->Mask(view_index, level);
  if (mask != nullptr) CopyIgnored(*mask, shown, &target_);
  const float loss = loss_.Compute(shown, target_, pool_, &loss_gradient_);
  if (mask != nullptr) FillIgnored(*mask, 0.0f, &loss_gradient_);
  if (exposed) {
    const AffineColor gradient = BackwardColor(
        color, rendered_.color, pool_, &color_sums_, &loss_gradient_);
    const ExposureOptions& exposure = options_.exposure;
    colors.Step(view_index,
                gradient,
                ExposureRate(exposure, share) * history_.rate_factor,
                exposure.pull);
  }
  return loss;
}

StatusOr<StepReport> Trainer::Step(const CancellationToken* cancellation) {
  FREEGS_RETURN_IF_ERROR(FinishMilestone(cancellation).status());
  if (model_.empty()) {
    return UnusableResultError("training: no Gaussian is left at iteration " +
                               std::to_string(iteration_) +
                               "; the photos show nothing in front of the "
                               "background, masks ignore all of it, or the "
                               "camera poses are wrong");
  }
  if (!history_.last_good) {
    if (!model_.AllFinite()) {
      return InitialNumbersError();
    }
    KeepAsGood();
  }
  if (iteration_ > 0 &&
      schedule_.ResolutionLevel(iteration_ - 1, images_->num_levels()) !=
          schedule_.ResolutionLevel(iteration_, images_->num_levels())) {
    loss_monitor_.Reset();
  }
  StepReport report;
  FREEGS_ASSIGN_OR_RETURN(report.loss, GradientStep());
  ++iteration_;
  const std::optional<std::string> trouble = FindTrouble(report.loss);
  report.recovered = trouble.has_value();
  if (trouble) {
    FREEGS_RETURN_IF_ERROR(GoBack(*trouble));
  } else {
    const Status followed = FollowSchedule(cancellation);
    report.interrupted = followed.code() == StatusCode::kInterrupted;
    if (!report.interrupted) {
      FREEGS_RETURN_IF_ERROR(followed);
      Average();
    }
  }
  report.iteration = iteration_;
  report.num_gaussians = model_.size();
  return report;
}

StatusOr<bool> Trainer::FinishMilestone(const CancellationToken* cancellation) {
  const std::optional<TrainingEvent> event = schedule_.MilestoneAt(iteration_);
  if (iteration_ == 0 || !event) return false;
  // Every milestone that was made has a record.
  const std::vector<MilestoneRecord>& made = history_.milestones;
  if (!made.empty() && made.back().iteration == iteration_) return false;
  FREEGS_RETURN_IF_ERROR(RunMilestone(*event, cancellation));
  Average();
  return true;
}

std::optional<std::string> Trainer::FindTrouble(float loss) {
  if (const auto trouble = loss_monitor_.Add(loss)) return trouble;
  const bool test_all = iteration_ % kFiniteTestInterval == 0 || done() ||
                        iteration_ % options_.snapshot_interval == 0 ||
                        schedule_.MilestoneAt(iteration_).has_value();
  if (!touched_finite_ || (test_all && !model_.AllFinite())) {
    return kNotFinite;
  }
  return std::nullopt;
}

StatusOr<bool> Trainer::GoBackUnlessFinite() {
  if (model().AllFinite()) return false;
  if (!history_.last_good) return InitialNumbersError();
  FREEGS_RETURN_IF_ERROR(GoBack(kNotFinite));
  return true;
}

Status Trainer::GoBack(const std::string& reason) {
  const GoodState& good = *history_.last_good;
  if (history_.recoveries.size() >=
      static_cast<size_t>(options_.max_recoveries)) {
    return UnusableResultError(
        "training diverged at iteration " + std::to_string(iteration_) + " (" +
        reason + "), after " + std::to_string(history_.recoveries.size()) +
        " returns to an earlier state at ever smaller learning rates; check "
        "the camera poses and the photos");
  }
  history_.rate_factor *= kRecoveryRateFactor;
  history_.recoveries.push_back(
      {iteration_, reason, good.iteration, history_.rate_factor});
  iteration_ = good.iteration;
  model_ = good.model;
  history_.colors = good.colors;
  history_.average.Clear();
  adam_.Reset(model_);
  statistics_.Reset(model_.size());
  loss_monitor_.Reset();
  return Status();
}

void Trainer::Average() {
  const double from =
      options_.average_from * static_cast<double>(schedule_.iterations());
  if (static_cast<double>(iteration_) <= from) return;
  if (iteration_ % kAverageInterval != 0 && !done()) return;
  history_.average.Add(model_, pool_);
}

void Trainer::KeepAsGood() {
  if (!history_.last_good) history_.last_good.emplace();
  // Assigning reuses the memory of the good state before.
  history_.last_good->iteration = iteration_;
  history_.last_good->model = model_;
  history_.last_good->colors = history_.colors;
}

Status Trainer::FollowSchedule(const CancellationToken* cancellation) {
  if (decay_ > 0 && iteration_ % options_.decay_interval == 0) {
    DecayOpacity(decay_, pool_, &model_);
  }
  if (const auto event = schedule_.MilestoneAt(iteration_)) {
    return RunMilestone(*event, cancellation);
  }
  if (schedule_.Densifies(iteration_)) {
    Densify(densification_,
            scene_extent_,
            options_.seed,
            iteration_,
            &model_,
            &adam_,
            &statistics_);
    SortInSpace();
  }
  if (iteration_ % options_.clear_interval == 0 &&
      static_cast<double>(iteration_) <=
          kClearShare * static_cast<double>(schedule_.iterations())) {
    ClearCameras();
  }
  if (iteration_ % options_.snapshot_interval == 0 && !model_.empty() &&
      loss_monitor_.Healthy()) {
    KeepAsGood();
  }
  return Status();
}

void Trainer::SortInSpace() {
  const std::vector<uint32_t> order = MortonOrder(model_);
  model_.Select(order);
  adam_.Select(order);
  statistics_.Select(order);
  history_.average.Clear();
}

void Trainer::ClearCameras() {
  const std::vector<uint32_t> kept = OutsideBalls(clear_balls_, model_, pool_);
  if (kept.empty() || kept.size() == model_.size()) return;
  model_.Select(kept);
  adam_.Select(kept);
  statistics_.Select(kept);
  history_.average.Clear();
}

int64_t Trainer::SimplificationBudget() const {
  const std::vector<Milestone>& milestones = schedule_.milestones();
  const bool pruned_later =
      !milestones.empty() && milestones.back().event == TrainingEvent::kPruning;
  const double slack =
      pruned_later ? options_.mini_splatting.simplify_slack : 1.0;
  return static_cast<int64_t>(static_cast<double>(options_.budget) * slack);
}

std::vector<PhotoExposure> Trainer::Exposures() const {
  const std::vector<PhotoColors::Entry>& entries = history_.colors.entries;
  std::vector<PhotoExposure> exposures;
  exposures.reserve(entries.size());
  for (size_t i = 0; i < entries.size(); ++i) {
    exposures.push_back({images_->view(i, 0).name, entries[i].color});
  }
  std::ranges::sort(exposures, NaturalLess, &PhotoExposure::photo);
  return exposures;
}

void Trainer::SetExposureChoice(const ExposureChoice& choice) {
  history_.exposure_choice = choice;
  history_.colors.entries.clear();
  if (choice.learn) history_.colors.entries.resize(images_->size());
}

Status Trainer::RunMilestone(TrainingEvent event,
                             const CancellationToken* cancellation) {
  MiniSplattingContext context;
  context.images = images_;
  context.colors = &history_.colors;
  context.level = schedule_.ResolutionLevel(iteration_, images_->num_levels());
  context.render = options_.render;
  context.scene_extent = scene_extent_;
  context.seed = options_.seed;
  context.iteration = iteration_;
  context.rasterizer = &rasterizer_;
  context.pool = &pool_;
  context.cancellation = cancellation;
  const MiniSplattingOptions& mini = options_.mini_splatting;
  MiniSplattingSummary summary;
  switch (event) {
    case TrainingEvent::kDepthReinitialization: {
      FREEGS_ASSIGN_OR_RETURN(
          summary,
          ReinitializeFromDepth(
              mini, options_.budget, context, &model_, &adam_));
      break;
    }
    case TrainingEvent::kSimplification: {
      FREEGS_ASSIGN_OR_RETURN(summary,
                              Simplify(mini,
                                       SimplificationBudget(),
                                       importance_metric_,
                                       context,
                                       &model_,
                                       &adam_));
      break;
    }
    case TrainingEvent::kPruning: {
      FREEGS_ASSIGN_OR_RETURN(summary,
                              PruneByImportance(mini,
                                                options_.budget,
                                                importance_metric_,
                                                context,
                                                &model_,
                                                &adam_));
      break;
    }
  }
  model_.antialiased = options_.antialiased;  // Also of a model begun anew.
  history_.milestones.push_back(
      {iteration_, event, summary.before, summary.after});
  statistics_.Reset(model_.size());
  loss_monitor_.Reset();
  history_.average.Clear();
  KeepAsGood();
  return Status();
}

TrainingCheckpointView Trainer::CheckpointView() {
  history_.loss = loss_monitor_.state();
  return {.iteration = iteration_,
          .model = &model_,
          .adam = &adam_.state(),
          .statistics = &statistics_,
          .history = &history_,
          .facts = {}};
}

TrainingCheckpoint Trainer::Save() const {
  TrainingCheckpoint checkpoint;
  checkpoint.iteration = iteration_;
  checkpoint.model = model_;
  checkpoint.adam = adam_.state();
  checkpoint.statistics = statistics_;
  checkpoint.history = history_;
  checkpoint.history.loss = loss_monitor_.state();
  return checkpoint;
}

Status Trainer::Restore(TrainingCheckpoint checkpoint) {
  const size_t colors = checkpoint.history.colors.entries.size();
  if (checkpoint.iteration > schedule_.iterations()) {
    return BadInputError("the checkpoint is of iteration " +
                         std::to_string(checkpoint.iteration) +
                         ", but the training has " +
                         std::to_string(schedule_.iterations()) +
                         "; remove the checkpoints to train anew");
  }
  if (colors != 0 && colors != images_->size()) {
    return BadInputError(
        "the checkpoint has the exposure of " + std::to_string(colors) +
        " photos, but the training has " + std::to_string(images_->size()) +
        "; remove the checkpoints to train anew");
  }
  if (checkpoint.iteration < 0 || !IsWhole(checkpoint)) {
    return BadInputError(
        "model, optimiser and statistics of the checkpoint do not belong "
        "together; remove the checkpoints to train anew");
  }
  iteration_ = checkpoint.iteration;
  model_ = std::move(checkpoint.model);
  model_.antialiased = options_.antialiased;
  adam_.set_state(std::move(checkpoint.adam));
  statistics_ = std::move(checkpoint.statistics);
  history_ = std::move(checkpoint.history);
  if (history_.last_good) {
    history_.last_good->model.antialiased = options_.antialiased;
  }
  history_.average.mean.antialiased = options_.antialiased;
  loss_monitor_.set_state(history_.loss);
  return Status();
}

}  // namespace freegs::splat
