// SPDX-License-Identifier: BSD-3-Clause
// Runs other programs without a shell, reads their output line by line, and
// makes sure that they end before or with this process.

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
  // The program, which is a path or a name in PATH, and its arguments.
  std::vector<std::string> argv;

  // Environment variables to set or replace.
  std::vector<std::pair<std::string, std::string>> environment;

  // The file to which standard output and error are appended; empty for none.
  std::filesystem::path log_file;

  // After so many seconds the program and its children are killed; 0 sets no
  // limit.
  double time_limit_s = 0;
};

struct ChildResult {
  // -1 when a signal ended the program, and when the system does not tell how
  // it ended.
  int exit_code = -1;
  int signal = 0;  // That signal; 0 when the program ended by itself.

  // Whether it was killed because of its time limit, and that limit.
  bool timed_out = false;
  double time_limit_s = 0;

  // The last lines of its output, for error messages.
  std::string tail;

  bool ok() const { return exit_code == 0; }
  // Says how the program ended: "exit code 1", "signal 11 (Segmentation fault)"
  // or "no end within 600 s".
  std::string Describe() const;
};

// Called with each line of output, without the '\n' or '\r' at its end.
using LineFn = std::function<void(std::string_view)>;

// Runs a program to its end:
//
//   ChildCommand command;
//   command.argv = {"colmap", "help"};
//   FREEGS_ASSIGN_OR_RETURN(const ChildResult result,
//                           RunChild(command, on_line, cancellation));
//   if (!result.ok()) Warn(result.Describe() + "\n" + result.tail);
//
// Returns kMissingDependency when the program cannot be started, kInterrupted
// when cancelled, and kInternal when a system call fails. A program that ran is
// no error, whatever its exit code. On cancellation the program and its
// children get SIGTERM, and two seconds later SIGKILL.
//
// The program has an empty standard input and a process group of its own. The
// kernel kills it when the calling thread ends. When this process ends, even by
// SIGKILL, a guard process kills the whole group.
//
// If this process ignores SIGCHLD, as it may have been told by the one that
// started it, it gets the default action back.
StatusOr<ChildResult> RunChild(const ChildCommand& command,
                               const LineFn& on_line,
                               const CancellationToken* cancellation);

// Several programs, some of which run at the same time.
struct ChildBatch {
  size_t count = 0;
  int max_parallel = 1;

  // Makes the command of program i. Called right before the program starts, in
  // the order of i.
  std::function<StatusOr<ChildCommand>(size_t i)> prepare;

  // Called when program i has ended, in the order in which programs end.
  std::function<Status(size_t i, const ChildResult& result)> finished;

  // Called with each line that program i writes. May be empty.
  std::function<void(size_t i, std::string_view line)> on_line;
};

// Runs the batch; all functions are called on the calling thread. At the first
// error of prepare, finished or the start of a program, it ends the programs
// that are still running and returns the error.
Status RunChildren(const ChildBatch& batch,
                   const CancellationToken* cancellation);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_COLMAP_CHILD_PROCESS_H_
