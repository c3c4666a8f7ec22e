// SPDX-License-Identifier: BSD-3-Clause
// How a caller asks long work to stop, how that work reports its progress, and
// the clock by which both are timed.

#ifndef FREEGS_CORE_CANCELLATION_H_
#define FREEGS_CORE_CANCELLATION_H_

#include <atomic>
#include <chrono>
#include <functional>
#include <string>

namespace freegs {

// A flag that a caller sets, from a signal handler or another thread, to ask
// long work to stop. The work reads it now and then and returns kInterrupted:
//
//   if (IsCancelled(token)) return InterruptedError("stopped on request");
class CancellationToken {
 public:
  void Cancel() { cancelled_.store(true, std::memory_order_relaxed); }
  bool cancelled() const { return cancelled_.load(std::memory_order_relaxed); }

 private:
  std::atomic<bool> cancelled_{false};
};

// Work that nobody can stop has no token.
inline bool IsCancelled(const CancellationToken* token) {
  return token != nullptr && token->cancelled();
}

// One report of progress.
struct Progress {
  std::string step;    // The work that is going on: "matching", "training".
  double done = 0;     // Units of work that are finished.
  double total = 0;    // All units of work; 0 when it is not known.
  std::string detail;  // A short free text: "loss 0.031, 48211 Gaussians".
};
using ProgressFn = std::function<void(const Progress&)>;

// Seconds of a clock that never goes back; its origin is arbitrary.
inline double SteadySeconds() {
  return std::chrono::duration<double>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

}  // namespace freegs

#endif  // FREEGS_CORE_CANCELLATION_H_
