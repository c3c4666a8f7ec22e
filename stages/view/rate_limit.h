// SPDX-License-Identifier: BSD-3-Clause
// Bounds how often something happens.

#ifndef FREEGS_STAGES_VIEW_RATE_LIMIT_H_
#define FREEGS_STAGES_VIEW_RATE_LIMIT_H_

#include <algorithm>
#include <mutex>

namespace freegs::stages {

// Allows `per_second` events a second, and as many at once after a pause.
// Several threads may use it.
class RateLimit {
 public:
  explicit RateLimit(double per_second)
      : per_second_(per_second), left_(per_second) {}

  // Whether an event may happen now; it counts then. `now` is in seconds.
  bool Take(double now) {
    const std::lock_guard lock(mutex_);
    left_ =
        std::min(per_second_, left_ + std::max(0.0, now - last_) * per_second_);
    last_ = std::max(last_, now);
    if (left_ < 1) return false;
    left_ -= 1;
    return true;
  }

 private:
  const double per_second_;
  std::mutex mutex_;
  double left_;
  double last_ = 0;
};

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_VIEW_RATE_LIMIT_H_
