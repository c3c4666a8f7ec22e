// SPDX-License-Identifier: BSD-3-Clause
// Says what happens at which iteration of a training. The milestones are those
// of Mini-Splatting (Fang and Wang 2024). They are given as shares of the
// iterations; comments name the paper's iteration, of 30000.

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
  // One Gaussian for each initial point, to the end.
  kNone,
  // 3DGS: clones and splits Gaussians where the image gradient is large.
  kGradient,
  // Makes a dense model, starts it again from its depth maps, then simplifies
  // it.
  kMiniSplatting,
};

struct ScheduleOptions {
  // Number of gradient steps. Each uses one view.
  int iterations = 7000;

  DensificationMethod method = DensificationMethod::kMiniSplatting;

  // The SH degree of the result. Training begins with degree 0. A further
  // degree is added after each sh_degree_interval (1000), counted from
  // sh_start; both are shares of the iterations. The paper has sh_start at its
  // simplification, 0.5. That is too late for trainings of a tenth of its
  // length, in which view-dependent colours would have too few steps.
  int sh_degree = 3;
  double sh_start = 0;
  double sh_degree_interval = 1.0 / 30;

  // Shares of the iterations at which the resolution of the images doubles.
  // Training begins at level resolution_steps.size() of the image pyramid:
  // small images cost less, and show all that a blurry first model can learn.
  std::vector<double> resolution_steps = {0.1, 0.3};

  // The level of the image pyramid at which training ends; 0 is full size.
  int finest_level = 0;

  // Number of iterations between densifications; 0 means none.
  int densify_interval = 100;

  // kGradient densifies between these shares of the iterations.
  double densify_start = 0.05;
  double densify_stop = 0.5;

  // kMiniSplatting densifies from this share (500) to the simplification.
  double mini_densify_start = 1.0 / 60;

  // Where the model starts again from its depth maps (5000, 10000); ascending.
  std::vector<double> depth_reinit_at = {1.0 / 6, 1.0 / 3};

  // Where the model is reduced to its important Gaussians (15000). The learning
  // rate of their positions then goes on from where it was at position_restart
  // (5000).
  double simplify_at = 0.5;
  double position_restart = 1.0 / 6;

  // Where the least important Gaussians are removed (20000); 1 or more never
  // prunes.
  double prune_at = 2.0 / 3;

  Status Check() const;
};

enum class TrainingEvent : uint8_t {
  kDepthReinitialization,
  kSimplification,
  kPruning
};
inline constexpr int kNumTrainingEvents = 3;

// "depth_reinitialization", "simplification", "pruning".
std::string_view TrainingEventName(TrainingEvent event);

struct Milestone {
  int64_t iteration = 0;  // The event follows this many steps.
  TrainingEvent event = TrainingEvent::kSimplification;

  friend bool operator==(const Milestone&, const Milestone&) = default;
};

// All answers are functions of the options and of `done`, the number of steps
// that have been made.
//
//   const TrainingSchedule schedule(options);
//   for (int64_t done = 0; done < schedule.iterations();) {
//     ... a gradient step with images of level
//         schedule.ResolutionLevel(done, num_levels) ...
//     ++done;
//     if (schedule.Densifies(done)) ...
//   }
class TrainingSchedule {
 public:
  // A milestone is dropped when fewer steps than this lie between it and the
  // milestone before it, or the beginning or the end of training. Only the
  // simplification always takes place, even after the last step, because it
  // brings the model down to its budget.
  static constexpr int64_t kMinSteps = 10;

  // The options must pass Check().
  explicit TrainingSchedule(const ScheduleOptions& options);

  int64_t iterations() const { return options_.iterations; }

  // The SH degree and the level of the image pyramid of the next step.
  int ShDegree(int64_t done) const;
  int ResolutionLevel(int64_t done, int num_levels) const;
  // The iteration at which the next step reads the decaying learning rate of
  // the positions, see LearningRatesAt.
  double PositionRateIteration(int64_t done) const;
  // Whether the next step has to collect DensificationStatistics. It need not
  // when no densification is left, or a milestone that resets them comes first.
  bool CollectsStatistics(int64_t done) const;

  // What happens directly after step number `done` > 0. At a milestone there is
  // no densification.
  bool Densifies(int64_t done) const;
  std::optional<TrainingEvent> MilestoneAt(int64_t done) const;

  // Ascending by iteration, no two at the same one.
  const std::vector<Milestone>& milestones() const { return milestones_; }

  // The milestones as a text such as "depth_reinitialization 833,
  // simplification 2500, pruning 3333", or "none".
  std::string Describe() const;

 private:
  void PlanMilestones();

  ScheduleOptions options_;
  std::vector<Milestone> milestones_;
  int64_t simplification_ = -1;     // Its iteration; -1 is none.
  int64_t densify_begin_ = 0;       // First iteration that may densify.
  int64_t densify_end_ = 0;         // One past the last such iteration.
  std::vector<int64_t> sharpened_;  // The iterations of resolution_steps.
};

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_TRAIN_TRAINING_SCHEDULE_H_
