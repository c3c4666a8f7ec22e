// SPDX-License-Identifier: BSD-3-Clause
// What happens when in training: everything that depends on the iteration
// only. Milestones are those of Mini-Splatting (Fang and Wang 2024), given as
// shares of the iterations; figures in comments are the paper's, of 30000.

#ifndef FREEGS_SPLAT_TRAIN_TRAINING_SCHEDULE_H_
#define FREEGS_SPLAT_TRAIN_TRAINING_SCHEDULE_H_

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/status.h"

namespace freegs::splat {

// How the number and places of the Gaussians are found.
enum class DensificationMethod {
  kNone,           // The initial points stay what they are.
  kGradient,       // 3DGS: clone and split where the image gradient is large.
  kMiniSplatting,  // Dense first, anew from depth, then simplified.
};

struct ScheduleOptions {
  // Gradient steps, one view each.
  int iterations = 7000;

  DensificationMethod method = DensificationMethod::kMiniSplatting;

  // Highest SH degree of the result, and the share of the iterations after
  // which each further degree is switched on (1000), counted from sh_start. The
  // paper has sh_start at its simplification, 0.5; with a tenth of its
  // iterations the colours that depend on the view then come too late.
  int sh_degree = 3;
  double sh_start = 0;
  double sh_degree_interval = 1.0 / 30;

  // Shares of the iterations at which the image resolution doubles: training
  // starts at level resolution_steps.size() of the image pyramid. Coarse images
  // cost less and carry what the first, blurry model can learn.
  std::vector<double> resolution_steps = {0.1, 0.3};

  // Level of the image pyramid that training ends at, 0 being full size.
  int finest_level = 0;

  // Iterations between densifications; 0 does none.
  int densify_interval = 100;

  // kGradient densifies between these shares of the iterations.
  double densify_start = 0.05;
  double densify_stop = 0.5;

  // kGradient sets opacities to at most 0.01 every so many iterations while
  // densifying; 0 never does. (3DGS does.)
  int opacity_reset_interval = 0;

  // kMiniSplatting densifies between this share (500) and the simplification.
  double mini_densify_start = 1.0 / 60;

  // The model starts again from its depth maps (5000, 10000); ascending.
  std::vector<double> depth_reinit_at = {1.0 / 6, 1.0 / 3};

  // The model is cut down to its important Gaussians (15000), whose positions
  // then learn at the rate of position_restart (5000) again.
  double simplify_at = 0.5;
  double position_restart = 1.0 / 6;

  // The least important Gaussians go (20000); 1 or more never prunes.
  double prune_at = 2.0 / 3;

  Status Check() const;
};

enum class TrainingEvent : uint8_t {
  kDepthReinitialization,
  kSimplification,
  kPruning
};
constexpr int kNumTrainingEvents = 3;

// "depth_reinitialization", "simplification", "pruning".
std::string_view TrainingEventName(TrainingEvent event);

struct Milestone {
  int64_t iteration = 0;  // The event follows this many steps.
  TrainingEvent event = TrainingEvent::kSimplification;

  friend bool operator==(const Milestone&, const Milestone&) = default;
};

// A pure function of the options; `done` is the number of steps done.
class TrainingSchedule {
 public:
  // A milestone has at least so many steps before it, after the milestone
  // before, and after it; one that has not is dropped. Only the simplification
  // always takes place, be it after the last step: it keeps the budget.
  static constexpr int64_t kMinSteps = 10;

  // The options must pass Check().
  explicit TrainingSchedule(const ScheduleOptions& options);

  int64_t iterations() const { return options_.iterations; }

  // Of the step to come.
  int ShDegree(int64_t done) const;
  int ResolutionLevel(int64_t done, int num_levels) const;
  // Where the positions' learning rate stands on its decay.
  double PositionRateIteration(int64_t done) const;
  // Whether a densification is going to read what the step finds out: none is
  // left to come, or a milestone comes first, when it is not.
  bool CollectsStatistics(int64_t done) const;

  // After the last of `done` > 0 steps; at a milestone nothing else happens.
  bool Densifies(int64_t done) const;
  bool ResetsOpacity(int64_t done) const;
  std::optional<TrainingEvent> MilestoneAt(int64_t done) const;

  // Whether enough steps are left after the simplification to start opacity,
  // scale and rotation again.
  bool MayRestartAtSimplification() const;

  // By iteration; no two at the same.
  const std::vector<Milestone>& milestones() const { return milestones_; }

  // "depth_reinitialization 833, ..., pruning 3333", or "none".
  std::string Describe() const;

 private:
  void PlanMilestones();

  ScheduleOptions options_;
  std::vector<Milestone> milestones_;
  int64_t simplification_ = -1;     // -1: none.
  int64_t densify_begin_ = 0;       // First iteration that may densify.
  int64_t densify_end_ = 0;         // One past the last.
  std::vector<int64_t> sharpened_;  // Iterations of resolution_steps.
};

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_TRAIN_TRAINING_SCHEDULE_H_
