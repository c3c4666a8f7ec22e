// SPDX-License-Identifier: BSD-3-Clause
// Running other programs: no shell, output read line by line, and no way for
// them to outlive us.

#ifndef FREEGS_SFM_COLMAP_CHILD_PROCESS_H_
#define FREEGS_SFM_COLMAP_CHILD_PROCESS_H_

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/cancellation.h"
#include "core/status.h"

namespace freegs::sfm {

struct ChildCommand {
  // The program (a path, or a name looked up in PATH) and its arguments. Never
  // goes through a shell.
  std::vector<std::string> argv;

  // Environment variables to set or replace.
  std::vector<std::pair<std::string, std::string>> environment;

  // Where standard output and error are appended; empty for nowhere.
  std::filesystem::path log_file;

  // Seconds after which the program and its children are killed; 0 for never.
  double time_limit_s = 0;
};

struct ChildResult {
  int exit_code = -1;  // -1 when a signal ended the program.
  int signal = 0;      // That signal; 0 when it ended by itself.

  // Whether it was killed because its time was over, and what that time was.
  bool timed_out = false;
  double time_limit_s = 0;

  // The last lines of its output, for error messages.
  std::string tail;

  bool ok() const { return exit_code == 0; }
  // "exit code 1", "signal 11 (Segmentation fault)", "no end within 600 s".
  std::string Describe() const;
};

// Called with each line of output, without its end ('\n' or '\r').
using LineFn = std::function<void(std::string_view)>;

// Runs a program to its end. Errors: kMissingDependency when it cannot be
// started, kInterrupted when cancelled (the program and its children get
// SIGTERM, and SIGKILL two seconds later), kInternal for failing system calls.
// A program that ran is not an error, whatever its exit code.
//
// The program gets an empty standard input, a process group of its own, and
// dies with the calling thread: when this process is killed, the kernel kills
// it too.
StatusOr<ChildResult> RunChild(const ChildCommand& command,
                               const LineFn& on_line,
                               const CancellationToken* cancellation);

// A number of programs, several at a time.
struct ChildBatch {
  size_t count = 0;
  int max_parallel = 1;

  // Called, in order, right before program i starts.
  std::function<StatusOr<ChildCommand>(size_t i)> prepare;

  // Called when program i ended, in the order in which they end.
  std::function<Status(size_t i, const ChildResult& result)> finished;

  // Called with each line that program i writes. May be empty.
  std::function<void(size_t i, std::string_view line)> on_line;
};

// Runs the batch on the calling thread. Stops at the first error that prepare,
// finished or a start returns, after ending the programs still running.
Status RunChildren(const ChildBatch& batch,
                   const CancellationToken* cancellation);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_COLMAP_CHILD_PROCESS_H_
