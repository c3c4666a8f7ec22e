// SPDX-License-Identifier: BSD-3-Clause

#include "splat/trainer.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/random.h"

namespace freegs::splat {
namespace {

// Random number streams; see core/random.h.
constexpr uint64_t kViewOrderStream = 0x76696577;  // "view"

// Parameters are looked at for NaN and infinity this often.
constexpr int64_t kFiniteTestInterval = 100;

}  // namespace

Status TrainerOptions::Check() const {
  if (iterations < 1)
    return InvalidArgumentError("iterations must be positive");
  if (sh_degree < 0 || sh_degree > kMaxShDegree) {
    return InvalidArgumentError("sh_degree must be 0 to 3");
  }
  if (!(sh_degree_interval >= 0)) {
    return InvalidArgumentError("sh_degree_interval must not be negative");
  }
  if (!std::is_sorted(resolution_steps.begin(), resolution_steps.end()) ||
      resolution_steps.size() > 4) {
    return InvalidArgumentError(
        "resolution_steps must be at most four ascending shares");
  }
  if (!(densify_start >= 0 && densify_stop <= 1) || densify_interval < 0 ||
      opacity_reset_interval < 0) {
    return InvalidArgumentError(
        "densification must lie within the iterations, its intervals must not "
        "be negative");
  }
  FREEGS_RETURN_IF_ERROR(densification.Check());
  FREEGS_RETURN_IF_ERROR(learning_rates.Check());
  return loss.Check();
}

Trainer::Trainer(const TrainerOptions& options,
                 GaussianModel initial_model,
                 double scene_extent,
                 TrainingImages* images,
                 ThreadPool* pool)
    : options_(options),
      scene_extent_(scene_extent),
      images_(images),
      pool_(pool),
      model_(std::move(initial_model)),
      loss_(options.loss) {
  adam_.Reset(model_);
  statistics_.Reset(model_.size());
}

size_t Trainer::ViewOfIteration(int64_t iteration) {
  // Each epoch shows every view once, in an order of its own.
  const auto count = static_cast<int64_t>(images_->size());
  const int64_t epoch = iteration / count;
  if (epoch != epoch_) {
    epoch_ = epoch;
    epoch_order_.resize(count);
    std::iota(epoch_order_.begin(), epoch_order_.end(), 0u);
    for (int64_t i = count - 1; i > 0; --i) {
      const uint64_t j = RandomIndex(options_.seed,
                                     kViewOrderStream,
                                     static_cast<uint64_t>(epoch * count + i),
                                     static_cast<uint64_t>(i + 1));
      std::swap(epoch_order_[i], epoch_order_[j]);
    }
  }
  return epoch_order_[iteration % count];
}

int Trainer::LevelOfIteration(int64_t iteration) const {
  const double share = static_cast<double>(iteration) / options_.iterations;
  const std::vector<double>& steps = options_.resolution_steps;
  const auto passed = std::upper_bound(steps.begin(), steps.end(), share);
  const auto level = static_cast<int>(steps.end() - passed);
  return std::min(level, images_->num_levels() - 1);
}

int Trainer::ShDegreeOfIteration(int64_t iteration) const {
  const double interval = options_.sh_degree_interval * options_.iterations;
  if (interval <= 0) return options_.sh_degree;
  return static_cast<int>(
      std::min<double>(options_.sh_degree,
                       std::floor(static_cast<double>(iteration) / interval)));
}

void Trainer::CollectTouched() {
  const Projection& projection = rasterizer_.projection();
  touched_flags_.assign(model_.size(), 0);
  for (const uint32_t i : projection.model_index) touched_flags_[i] = 1;
  touched_.clear();
  for (uint32_t i = 0; i < touched_flags_.size(); ++i) {
    if (touched_flags_[i] != 0) touched_.push_back(i);
  }
  radii_.resize(projection.size());
  for (size_t k = 0; k < projection.size(); ++k) {
    const Splat& splat = projection.splats[k];
    radii_[k] = std::max(splat.extent_x, splat.extent_y);
  }
}

void Trainer::MaybeDensify() {
  const int interval = options_.densify_interval;
  const double begin = options_.densify_start * options_.iterations;
  const double end = options_.densify_stop * options_.iterations;
  const auto now = static_cast<double>(iteration_);
  if (interval <= 0 || now < begin || now >= end) return;
  if (iteration_ % interval == 0) {
    Densify(options_.densification,
            scene_extent_,
            options_.seed,
            iteration_,
            &model_,
            &adam_,
            &statistics_);
  }
  const int reset = options_.opacity_reset_interval;
  if (reset > 0 && iteration_ % reset == 0 && now + reset < end) {
    ResetOpacity(0.01, &model_, &adam_);
  }
}

StatusOr<StepReport> Trainer::Step() {
  const size_t view_index = ViewOfIteration(iteration_);
  const int level = LevelOfIteration(iteration_);
  const int sh_degree = ShDegreeOfIteration(iteration_);
  if (model_.sh_degree < sh_degree) {
    model_.SetShDegree(sh_degree);
    adam_.SetShDegree(sh_degree);
  }
  gradients_.sh_degree = model_.sh_degree;
  gradients_.Resize(model_.size());

  const View view = images_->view(view_index, level);
  FREEGS_RETURN_IF_ERROR(images_->Fetch(view_index, level, &target_));
  rasterizer_.Forward(model_,
                      view.camera,
                      view.cam_from_world,
                      options_.render,
                      {},
                      *pool_,
                      &rendered_);
  const float loss =
      loss_.Compute(rendered_.color, target_, *pool_, &loss_gradient_);
  rasterizer_.Backward(
      model_, {.color = &loss_gradient_}, rendered_, *pool_, &gradients_);
  CollectTouched();
  statistics_.AddView(rasterizer_.projection().model_index,
                      rasterizer_.mean2d_gradients(),
                      radii_,
                      view.camera.width,
                      view.camera.height);
  adam_.Step(LearningRatesAt(options_.learning_rates,
                             scene_extent_,
                             static_cast<double>(iteration_)),
             gradients_,
             touched_,
             *pool_,
             &model_);
  ++iteration_;
  MaybeDensify();

  const bool test_all = iteration_ % kFiniteTestInterval == 0 || done();
  if (!std::isfinite(loss) || (test_all && !model_.AllFinite())) {
    return UnusableResultError(
        "training diverged at iteration " + std::to_string(iteration_) +
        ": a parameter or the loss is not a finite number; check the camera "
        "poses, or lower the learning rates");
  }
  return StepReport{iteration_, loss, model_.size()};
}

TrainingCheckpoint Trainer::Save() const {
  TrainingCheckpoint checkpoint;
  checkpoint.iteration = iteration_;
  checkpoint.model = model_;
  checkpoint.adam = adam_.state();
  checkpoint.statistics = statistics_;
  return checkpoint;
}

Status Trainer::Restore(TrainingCheckpoint checkpoint) {
  const size_t count = checkpoint.model.size();
  if (checkpoint.iteration < 0 || checkpoint.iteration > options_.iterations ||
      checkpoint.adam.first_moments.size() != count ||
      checkpoint.adam.second_moments.size() != count ||
      checkpoint.adam.first_moments.sh_degree != checkpoint.model.sh_degree ||
      checkpoint.statistics.size() != count) {
    return BadInputError(
        "checkpoint: model, optimiser and statistics do not belong together");
  }
  iteration_ = checkpoint.iteration;
  model_ = std::move(checkpoint.model);
  adam_.set_state(std::move(checkpoint.adam));
  statistics_ = std::move(checkpoint.statistics);
  return Status();
}

}  // namespace freegs::splat
