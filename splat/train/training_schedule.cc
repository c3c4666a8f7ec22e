// SPDX-License-Identifier: BSD-3-Clause

#include "splat/train/training_schedule.h"

#include <algorithm>
#include <cmath>

#include "splat/scene/gaussian_model.h"

namespace freegs::splat {
namespace {

bool IsShare(double value) { return value >= 0 && value <= 1; }

// The first iteration at or after a share of all iterations.
int64_t FirstFrom(double share, int64_t iterations) {
  return static_cast<int64_t>(
      std::ceil(share * static_cast<double>(iterations)));
}

int64_t Nearest(double share, int64_t iterations) {
  return std::llround(share * static_cast<double>(iterations));
}

}  // namespace

std::string_view TrainingEventName(TrainingEvent event) {
  switch (event) {
    case TrainingEvent::kDepthReinitialization:
      return "depth_reinitialization";
    case TrainingEvent::kSimplification:
      return "simplification";
    case TrainingEvent::kPruning:
      break;
  }
  return "pruning";
}

Status ScheduleOptions::Check() const {
  if (iterations < 1) {
    return InvalidArgumentError("iterations must be positive");
  }
  if (sh_degree < 0 || sh_degree > kMaxShDegree) {
    return InvalidArgumentError("sh_degree must be 0 to 3");
  }
  if (!(sh_degree_interval >= 0) || !IsShare(sh_start)) {
    return InvalidArgumentError(
        "sh_start must be a share, sh_degree_interval not negative");
  }
  const auto are_shares = [](const std::vector<double>& values) {
    return std::is_sorted(values.begin(), values.end()) &&
           std::all_of(values.begin(), values.end(), IsShare);
  };
  if (!are_shares(resolution_steps) || resolution_steps.size() > 4) {
    return InvalidArgumentError(
        "resolution_steps must be at most four ascending shares");
  }
  if (finest_level < 0) {
    return InvalidArgumentError("finest_level must not be negative");
  }
  if (!IsShare(densify_start) || !IsShare(densify_stop) ||
      !IsShare(mini_densify_start) || densify_interval < 0) {
    return InvalidArgumentError(
        "densification must lie within the iterations, its interval must not "
        "be negative");
  }
  if (!are_shares(depth_reinit_at)) {
    return InvalidArgumentError("depth_reinit_at must be ascending shares");
  }
  if (!IsShare(simplify_at) || !IsShare(position_restart) || !(prune_at >= 0)) {
    return InvalidArgumentError(
        "simplify_at, position_restart and prune_at must be shares of the "
        "iterations");
  }
  return Status();
}

TrainingSchedule::TrainingSchedule(const ScheduleOptions& options)
    : options_(options) {
  const int64_t total = options_.iterations;
  switch (options_.method) {
    case DensificationMethod::kNone:
      break;
    case DensificationMethod::kGradient:
      densify_begin_ = FirstFrom(options_.densify_start, total);
      densify_end_ = FirstFrom(options_.densify_stop, total);
      break;
    case DensificationMethod::kMiniSplatting:
      PlanMilestones();
      densify_begin_ = FirstFrom(options_.mini_densify_start, total);
      densify_end_ = simplification_;
      break;
  }
  if (options_.densify_interval <= 0) densify_end_ = 0;
  for (const double share : options_.resolution_steps) {
    sharpened_.push_back(FirstFrom(share, total));
  }
}

void TrainingSchedule::PlanMilestones() {
  const int64_t total = options_.iterations;
  simplification_ =
      std::clamp<int64_t>(Nearest(options_.simplify_at, total), 1, total);
  int64_t last = 0;
  for (const double share : options_.depth_reinit_at) {
    const int64_t at = Nearest(share, total);
    if (at - last < kMinSteps || simplification_ - at < kMinSteps) continue;
    milestones_.push_back({at, TrainingEvent::kDepthReinitialization});
    last = at;
  }
  milestones_.push_back({simplification_, TrainingEvent::kSimplification});
  if (options_.prune_at >= 1) return;
  const int64_t prune = Nearest(options_.prune_at, total);
  if (prune - simplification_ >= kMinSteps && total - prune >= kMinSteps) {
    milestones_.push_back({prune, TrainingEvent::kPruning});
  }
}

int TrainingSchedule::ShDegree(int64_t done) const {
  const double start = options_.sh_start * options_.iterations;
  if (static_cast<double>(done) < start) return 0;
  const double interval = options_.sh_degree_interval * options_.iterations;
  if (interval <= 0) return options_.sh_degree;
  return static_cast<int>(std::min<double>(
      options_.sh_degree,
      std::floor((static_cast<double>(done) - start) / interval)));
}

int TrainingSchedule::ResolutionLevel(int64_t done, int num_levels) const {
  const auto passed =
      std::upper_bound(sharpened_.begin(), sharpened_.end(), done);
  const auto level =
      options_.finest_level + static_cast<int>(sharpened_.end() - passed);
  return std::min(level, num_levels - 1);
}

double TrainingSchedule::PositionRateIteration(int64_t done) const {
  if (simplification_ < 0 || done < simplification_) {
    return static_cast<double>(done);
  }
  return options_.position_restart * options_.iterations +
         static_cast<double>(done - simplification_);
}

bool TrainingSchedule::CollectsStatistics(int64_t done) const {
  const int64_t interval = options_.densify_interval;
  if (densify_end_ <= done) return false;
  // The next densification by the interval alone, whatever the milestones.
  const int64_t from = std::max(done + 1, std::max<int64_t>(densify_begin_, 1));
  const int64_t next = (from + interval - 1) / interval * interval;
  if (next >= densify_end_) return false;
  return std::none_of(
      milestones_.begin(), milestones_.end(), [&](const Milestone& milestone) {
        return milestone.iteration > done && milestone.iteration <= next;
      });
}

bool TrainingSchedule::Densifies(int64_t done) const {
  return done >= densify_begin_ && done < densify_end_ &&
         done % options_.densify_interval == 0 && !MilestoneAt(done);
}

std::optional<TrainingEvent> TrainingSchedule::MilestoneAt(int64_t done) const {
  for (const Milestone& milestone : milestones_) {
    if (milestone.iteration == done) return milestone.event;
  }
  return std::nullopt;
}

std::string TrainingSchedule::Describe() const {
  std::string text;
  for (const Milestone& milestone : milestones_) {
    if (!text.empty()) text += ", ";
    text += std::string(TrainingEventName(milestone.event)) + " " +
            std::to_string(milestone.iteration);
  }
  return text.empty() ? "none" : text;
}

}  // namespace freegs::splat
