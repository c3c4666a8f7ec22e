// SPDX-License-Identifier: BSD-3-Clause

#include "splat/train/stability.h"

#include <algorithm>
#include <cmath>

#include "core/number_text.h"

namespace freegs::splat {
namespace {

// The smoothed loss of fewer steps says nothing.
constexpr int64_t kMinSteps = 5;
constexpr double kSenselessLoss = 2;
constexpr double kWorseFactor = 3;
constexpr double kWorseBy = 0.3;

double Limit(double best) {
  return std::max(kWorseFactor * best, best + kWorseBy);
}

// Leaves NaN as it is.
void Clamp(float lowest, float highest, float* value) {
  if (*value < lowest) *value = lowest;
  if (*value > highest) *value = highest;
}

void BoundQuaternion(float* q) {
  const float square = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
  if (square >= kMinQuaternionNorm * kMinQuaternionNorm &&
      square <= kMaxQuaternionNorm * kMaxQuaternionNorm) {
    return;
  }
  const double norm = std::hypot(std::hypot(static_cast<double>(q[0]), q[1]),
                                 std::hypot(static_cast<double>(q[2]), q[3]));
  if (!std::isfinite(norm)) return;
  if (norm == 0) q[0] = 1;
  for (int k = 0; norm > 0 && k < 4; ++k) {
    q[k] = static_cast<float>(q[k] / norm);
  }
}

bool Finite(std::span<const float> values) {
  return std::all_of(
      values.begin(), values.end(), [](float v) { return std::isfinite(v); });
}

}  // namespace

bool BoundParameters(double scene_extent,
                     std::span<const uint32_t> touched,
                     GaussianModel* model) {
  const auto lowest =
      static_cast<float>(std::log(kMinBoundedScale * scene_extent));
  const auto highest =
      static_cast<float>(std::log(kMaxBoundedScale * scene_extent));
  bool finite = true;
  for (const size_t i : touched) {
    float* const log_scale = &model->log_scales[3 * i];
    float* const rotation = &model->rotations[4 * i];
    float* const logit = &model->opacity_logits[i];
    finite = finite && Finite({&model->means[3 * i], 3}) &&
             Finite({log_scale, 3}) && Finite({rotation, 4}) &&
             std::isfinite(*logit);
    for (int axis = 0; axis < 3; ++axis) {
      Clamp(lowest, highest, &log_scale[axis]);
    }
    Clamp(-kMaxOpacityLogit, kMaxOpacityLogit, logit);
    BoundQuaternion(rotation);
  }
  return finite;
}

LossMonitor::LossMonitor(size_t num_views)
    : horizon_(std::clamp<int64_t>(static_cast<int64_t>(num_views), 20, 100)) {
  decay_ = 1 - 1.0 / static_cast<double>(horizon_);
}

double LossMonitor::Smoothed() const {
  if (state_.steps == 0) return 0;
  return state_.sum / (1 - std::pow(decay_, static_cast<double>(state_.steps)));
}

std::optional<std::string> LossMonitor::Add(double loss) {
  if (!std::isfinite(loss)) return "the loss is not a finite number";
  ++state_.steps;
  state_.sum = decay_ * state_.sum + (1 - decay_) * loss;
  const double smoothed = Smoothed();
  const bool known = state_.steps > horizon_;
  const bool exploded =
      (state_.steps >= kMinSteps && smoothed > kSenselessLoss) ||
      (known && smoothed > Limit(state_.best));
  if (exploded) {
    return "the loss rose to " + FormatSignificant(smoothed, 3) +
           (known ? ", far above its best" : "");
  }
  if (state_.steps == horizon_) state_.best = smoothed;
  state_.best = std::min(state_.best, smoothed);
  return std::nullopt;
}

bool LossMonitor::Healthy() const {
  if (state_.steps < horizon_) return true;
  return Smoothed() <= 0.5 * (state_.best + Limit(state_.best));
}

}  // namespace freegs::splat
