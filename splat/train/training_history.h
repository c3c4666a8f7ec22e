// SPDX-License-Identifier: BSD-3-Clause
// The record of a training: what it needs to go back when it diverges, and what
// it reports in the end. It is part of the checkpoint.

#ifndef FREEGS_SPLAT_TRAIN_TRAINING_HISTORY_H_
#define FREEGS_SPLAT_TRAIN_TRAINING_HISTORY_H_

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "splat/optim/exposure.h"
#include "splat/optim/model_average.h"
#include "splat/scene/gaussian_model.h"
#include "splat/train/exposure_choice.h"
#include "splat/train/training_schedule.h"

namespace freegs::splat {

// A milestone that has taken place.
struct MilestoneRecord {
  int64_t iteration = 0;
  TrainingEvent event = TrainingEvent::kSimplification;
  uint64_t gaussians_before = 0;
  uint64_t gaussians_after = 0;

  friend bool operator==(const MilestoneRecord&,
                         const MilestoneRecord&) = default;
};

// A return to the last good state after training had diverged.
struct Recovery {
  int64_t iteration = 0;  // Where the divergence was found.
  std::string reason;
  int64_t back_to = 0;     // The iteration of the state gone back to.
  double rate_factor = 1;  // Factor of all learning rates from then on.

  friend bool operator==(const Recovery&, const Recovery&) = default;
};

// The scene and the photographs' colours from a time when training was healthy.
struct GoodState {
  int64_t iteration = 0;
  GaussianModel model;
  PhotoColors colors;
};

// The state of a LossMonitor.
struct LossMonitorState {
  int64_t steps = 0;
  double sum = 0;   // Exponentially weighted sum of the losses.
  double best = 0;  // Smallest smoothed loss since the first epoch.

  friend bool operator==(const LossMonitorState&,
                         const LossMonitorState&) = default;
};

// What has happened in a training so far, and what it knows of the photographs.
struct TrainingHistory {
  std::vector<MilestoneRecord> milestones;
  std::vector<Recovery> recoveries;
  double rate_factor = 1;  // Factor of all learning rates, see Recovery.
  LossMonitorState loss;
  std::optional<ExposureChoice> exposure_choice;  // Where there was a search.
  PhotoColors colors;                             // Where exposure is learnt.
  std::optional<GoodState> last_good;
  ModelAverage average;  // Mean of the last steps, see TrainerOptions.
};

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_TRAIN_TRAINING_HISTORY_H_
