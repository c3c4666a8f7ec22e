// SPDX-License-Identifier: BSD-3-Clause
// Handles Ctrl-C, kill and a closed terminal: the first signal asks the program
// to save a checkpoint and stop, one that comes later ends it at once.

#ifndef FREEGS_PIPELINE_INTERRUPT_H_
#define FREEGS_PIPELINE_INTERRUPT_H_

#include <array>
#include <csignal>

#include "core/cancellation.h"

namespace freegs::pipeline {

// As long as the object lives, SIGINT, SIGTERM and SIGHUP cancel `token`.
// Within a second of that further signals do nothing, because some programs
// send their signal twice. A signal after that second ends the program with
// exit code 130 and without cleaning up; a workspace stays usable then. A
// SIGHUP that was ignored before (nohup) stays ignored. SIGPIPE is ignored:
// output that nobody reads must not end a run. There may be one guard at a
// time. Its destructor puts the earlier handlers back.
class InterruptGuard {
 public:
  // checkpoint: whether what is cancelled saves one, which the note of the
  // first signal then says.
  InterruptGuard(CancellationToken* token, bool checkpoint);
  ~InterruptGuard();
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;

 private:
  static constexpr std::array kSignals = {SIGINT, SIGTERM, SIGHUP, SIGPIPE};
  std::array<struct sigaction, kSignals.size()> old_;
};

}  // namespace freegs::pipeline

#endif  // FREEGS_PIPELINE_INTERRUPT_H_
