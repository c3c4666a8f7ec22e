// SPDX-License-Identifier: BSD-3-Clause
// What training remembers of its own course, to go back when it diverges and
// to report in the end. Part of the checkpoint.

#ifndef FREEGS_SPLAT_TRAIN_TRAINING_HISTORY_H_
#define FREEGS_SPLAT_TRAIN_TRAINING_HISTORY_H_

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "splat/train/budget_choice.h"
#include "splat/scene/gaussian_model.h"
#include "splat/train/training_schedule.h"

namespace freegs::splat {

// A milestone passed.
struct MilestoneRecord {
  int64_t iteration = 0;
  TrainingEvent event = TrainingEvent::kSimplification;
  uint64_t gaussians_before = 0;
  uint64_t gaussians_after = 0;

  friend bool operator==(const MilestoneRecord&,
                         const MilestoneRecord&) = default;
};

// A return to the last good state.
struct Recovery {
  int64_t iteration = 0;  // At which divergence was found.
  std::string reason;
  int64_t back_to = 0;     // Iteration of the state taken up again.
  double rate_factor = 1;  // Of all learning rates from then on.

  friend bool operator==(const Recovery&, const Recovery&) = default;
};

// A model that was found healthy.
struct GoodState {
  int64_t iteration = 0;
  GaussianModel model;
};

// See LossMonitor.
struct LossMonitorState {
  int64_t steps = 0;
  double sum = 0;   // Decaying, not yet normalised.
  double best = 0;  // Smallest smoothed loss, once known.

  friend bool operator==(const LossMonitorState&,
                         const LossMonitorState&) = default;
};

struct TrainingHistory {
  std::vector<MilestoneRecord> milestones;
  std::vector<Recovery> recoveries;
  double rate_factor = 1;
  LossMonitorState loss;
  std::optional<BudgetChoice> budget_choice;  // Once searched for.
  std::optional<GoodState> last_good;
};

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_TRAIN_TRAINING_HISTORY_H_
