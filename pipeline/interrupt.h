// SPDX-License-Identifier: BSD-3-Clause
// Ctrl-C and kill: the first signal asks for a checkpoint, the second ends the
// program at once.

#ifndef FREEGS_PIPELINE_INTERRUPT_H_
#define FREEGS_PIPELINE_INTERRUPT_H_

#include <csignal>

#include "core/cancellation.h"

namespace freegs::pipeline {

// While it lives, SIGINT and SIGTERM cancel `token`; a second signal exits with
// 130 without cleaning up, which a workspace survives. At most one at a time;
// the handlers that were there before come back at the end.
class InterruptGuard {
 public:
  explicit InterruptGuard(CancellationToken* token);
  ~InterruptGuard();
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;

 private:
  struct sigaction old_int_;
  struct sigaction old_term_;
};

}  // namespace freegs::pipeline

#endif  // FREEGS_PIPELINE_INTERRUPT_H_
