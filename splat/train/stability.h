// SPDX-License-Identifier: BSD-3-Clause
// Keeps parameters within sensible bounds, and notices when training diverges.

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

// Bounds that no useful Gaussian comes near. One beyond them is too small to be
// seen, many times larger than the scene, or so opaque or transparent that its
// opacity no longer changes.
// Smallest and largest standard deviation, as multiples of the scene extent:
inline constexpr double kMinBoundedScale = 1e-7;
inline constexpr double kMaxBoundedScale = 100;
// Largest absolute value of an opacity logit (opacity 3e-7 or 1 - 3e-7):
inline constexpr float kMaxOpacityLogit = 15;
// A quaternion with a smaller or larger norm is normalised. Only its direction
// matters to the picture, but its gradient is in proportion to 1 / norm.
inline constexpr float kMinQuaternionNorm = 0.1f;
inline constexpr float kMaxQuaternionNorm = 10;

// Brings the Gaussians listed (no repeats) back within the bounds. Returns
// whether all their positions, scales, rotations and opacities were finite;
// values that are not finite stay as they are. Several threads may call it at
// the same time for different Gaussians.
bool BoundParameters(double scene_extent,
                     std::span<const uint32_t> touched,
                     GaussianModel* model);

// Watches the loss, smoothed exponentially over about one epoch (at least 20
// and at most 100 steps), for values that no healthy training shows. The loss
// also jumps when the size of the images changes or the model starts again:
// call Reset then.
class LossMonitor {
 public:
  explicit LossMonitor(size_t num_views);

  void Reset() { state_ = LossMonitorState(); }

  // Adds the loss of a step. Returns what is wrong, or nothing. Wrong is a loss
  // that is not finite; a smoothed loss above 2, which two images with values
  // in [0, 1] cannot have; and, after the first epoch, a smoothed loss above
  // both 3 times its smallest value so far and that value + 0.3.
  std::optional<std::string> Add(double loss);

  // Whether the state of training is good enough to come back to later: the
  // smoothed loss must be at most halfway between its smallest value and the
  // limit above which Add reports an error. Always true in the first epoch.
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
