// SPDX-License-Identifier: BSD-3-Clause
// Keeps training from running away, and notices when it does.

#ifndef FREEGS_SPLAT_TRAIN_STABILITY_H_
#define FREEGS_SPLAT_TRAIN_STABILITY_H_

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "splat/scene/gaussian_model.h"
#include "splat/train/training_history.h"

namespace freegs::splat {

// Bounds that no sound Gaussian comes near: what lies beyond is invisible,
// fills the sky many times over, or is too opaque to change in a step.
// Standard deviations, in terms of the scene extent:
constexpr double kMinBoundedScale = 1e-7;
constexpr double kMaxBoundedScale = 100;
// Opacity logits, to both sides (opacity 3e-7 and 1 - 3e-7):
constexpr float kMaxOpacityLogit = 15;
// A quaternion whose norm leaves these is normalised; only its direction
// counts, but the size of its gradient is the norm's reciprocal.
constexpr float kMinQuaternionNorm = 0.1f;
constexpr float kMaxQuaternionNorm = 10;

// Brings the Gaussians listed (no repeats) back within the bounds. Returns
// whether their positions, scales, rotations and opacities were finite; those
// that are not stay as they are. Concurrent calls may not share Gaussians.
bool BoundParameters(double scene_extent,
                     std::span<const uint32_t> touched,
                     GaussianModel* model);

// Watches the loss, smoothed exponentially over about one epoch (20 to 100
// steps), for values that no healthy training shows. A new picture size or a
// restarted model moves the loss: Reset then.
class LossMonitor {
 public:
  explicit LossMonitor(size_t num_views);

  void Reset() { state_ = LossMonitorState(); }

  // Adds the loss of a step. What is wrong, if anything: the loss is not
  // finite; the smoothed loss is above 2, which no image within [0, 1] reaches
  // against another; or, after the first epoch, it has passed both 3 times its
  // best and its best + 0.3.
  std::optional<std::string> Add(double loss);

  // Whether the smoothed loss is at most half the way from its best to where
  // Add complains: otherwise the state is not worth coming back to. True in the
  // first epoch.
  bool Healthy() const;

  const LossMonitorState& state() const { return state_; }
  void set_state(const LossMonitorState& state) { state_ = state; }

 private:
  double Smoothed() const;

  double decay_;
  int64_t horizon_;
  LossMonitorState state_;
};

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_TRAIN_STABILITY_H_
