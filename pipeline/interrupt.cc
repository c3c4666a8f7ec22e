// SPDX-License-Identifier: BSD-3-Clause

#include "pipeline/interrupt.h"

#include <atomic>
#include <cerrno>
#include <cstdint>
#include <ctime>
#include <string_view>
#include <unistd.h>

#include "core/status.h"
#include "pipeline/exit_code.h"

namespace freegs::pipeline {
namespace {

// A signal handler has no other way to its token.
std::atomic<CancellationToken*> current_token{nullptr};
static_assert(std::atomic<CancellationToken*>::is_always_lock_free);

// Whether the first signal leads to a checkpoint.
std::atomic<bool> saves_checkpoint{false};
static_assert(std::atomic<bool>::is_always_lock_free);

// When the first signal came, on the monotonic clock; 0 before that.
std::atomic<int64_t> first_signal_ns{0};
static_assert(std::atomic<int64_t>::is_always_lock_free);

// The program `timeout` and some job managers send the same signal to a process
// and to its whole group, so that it comes twice within an instant. A person
// who presses Ctrl-C again has read the note and takes longer.
constexpr int64_t kSameSignalNs = 1'000'000'000;

// Calls only what is safe in a signal handler.
void Cancel() {
  CancellationToken* token = current_token.load(std::memory_order_relaxed);
  if (token == nullptr) _exit(ExitCode(StatusCode::kInterrupted));
  timespec time = {};
  clock_gettime(CLOCK_MONOTONIC, &time);
  const int64_t now = time.tv_sec * int64_t{1'000'000'000} + time.tv_nsec;
  int64_t first = 0;
  if (!first_signal_ns.compare_exchange_strong(first, now)) {
    if (now - first < kSameSignalNs) return;
    _exit(ExitCode(StatusCode::kInterrupted));
  }
  token->Cancel();
  constexpr std::string_view kNote =
      "\ninterrupted: stopping (again after a second to stop at once)\n";
  constexpr std::string_view kCheckpointNote =
      "\ninterrupted: stopping, with a checkpoint where there is one (again "
      "after a second to stop at once)\n";
  const std::string_view note = saves_checkpoint.load(std::memory_order_relaxed)
                                    ? kCheckpointNote
                                    : kNote;
  [[maybe_unused]] const ssize_t ignored =
      write(STDERR_FILENO, note.data(), note.size());
}

// What was interrupted may look at errno afterwards.
void OnSignal(int) {
  const int saved = errno;
  Cancel();
  errno = saved;
}

}  // namespace

InterruptGuard::InterruptGuard(CancellationToken* token, bool checkpoint) {
  first_signal_ns.store(0);
  saves_checkpoint.store(checkpoint, std::memory_order_relaxed);
  current_token.store(token, std::memory_order_relaxed);
  struct sigaction action = {};
  sigemptyset(&action.sa_mask);
  // Without SA_RESTART: a wait for a child or a read wakes up to see the token.
  for (size_t i = 0; i < kSignals.size(); ++i) {
    action.sa_handler = kSignals[i] == SIGPIPE ? SIG_IGN : OnSignal;
    sigaction(kSignals[i], nullptr, &old_[i]);
    if (kSignals[i] == SIGHUP && old_[i].sa_handler == SIG_IGN) continue;
    sigaction(kSignals[i], &action, nullptr);
  }
}

InterruptGuard::~InterruptGuard() {
  for (size_t i = 0; i < kSignals.size(); ++i) {
    sigaction(kSignals[i], &old_[i], nullptr);
  }
  current_token.store(nullptr, std::memory_order_relaxed);
}

}  // namespace freegs::pipeline
