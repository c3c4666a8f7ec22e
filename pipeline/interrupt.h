// SPDX-License-Identifier: BSD-3-Clause
// Handles Ctrl-C and kill: the first signal asks the program to save a
// checkpoint and stop, the second ends it at once.

#ifndef FREEGS_PIPELINE_INTERRUPT_H_
#define FREEGS_PIPELINE_INTERRUPT_H_

#include <csignal>

#include "core/cancellation.h"

namespace freegs::pipeline {

// As long as the object lives, SIGINT and SIGTERM cancel `token`. A second
// signal ends the program with exit code 130 and without cleaning up; a
// workspace stays usable then. There may be one guard at a time. Its destructor
// puts the earlier handlers back.
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
