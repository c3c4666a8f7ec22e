// SPDX-License-Identifier: BSD-3-Clause
// How a caller asks long work to stop, and how that work reports how far it is.

#ifndef FREEGS_CORE_CANCELLATION_H_
#define FREEGS_CORE_CANCELLATION_H_

#include <atomic>
#include <functional>
#include <string>

namespace freegs {

// Set from a signal handler or another thread; polled by long loops.
class CancellationToken {
 public:
  void Cancel() { cancelled_.store(true, std::memory_order_relaxed); }
  bool cancelled() const { return cancelled_.load(std::memory_order_relaxed); }

 private:
  std::atomic<bool> cancelled_{false};
};

// One report of progress: done of total units, and a short free text such as
// "loss 0.031, 48211 Gaussians". A total of 0 means unknown.
struct Progress {
  std::string step;  // What is being done: "matching", "training".
  double done = 0;
  double total = 0;
  std::string detail;
};
using ProgressFn = std::function<void(const Progress&)>;

}  // namespace freegs

#endif  // FREEGS_CORE_CANCELLATION_H_
