// SPDX-License-Identifier: BSD-3-Clause
// Runs a command of the program in a process of its own, and keeps how it ended
// and what it told the user.

#ifndef FREEGS_STAGES_BENCH_CHILD_OUTCOME_H_
#define FREEGS_STAGES_BENCH_CHILD_OUTCOME_H_

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "core/status.h"
#include "stages/bench/bench_context.h"

namespace freegs::stages {

struct ChildOutcome {
  int exit_code = 0;   // -1 when a signal or the time limit ended it.
  std::string reason;  // Why it failed; empty when it did not.
  bool timed_out = false;
  double time_limit_s = 0;  // That it had; 0 for none.

  // Its warnings and errors; of more than ten the first and the last five.
  std::vector<std::string> said;

  // All kinds of warnings and errors that there were: the first line of each.
  std::vector<std::string> kinds;

  // The hashes of the programs that made the result, and of those that made
  // what it rests on.
  std::set<std::string> programs;

  bool ok() const { return exit_code == 0; }

  // Whether another attempt with this time limit (0 for none) would end the
  // same way: it is done, the method failed (4), the input is no good (3), or
  // its time ran out and it would not get more.
  bool IsFinal(double limit_s) const;
};

// Two warnings are of one kind when this is the same for both: the line with
// "#" for each of its numbers, and without numbers that are the first folder of
// a path. Such folders are those of photographs in another order ("0003/a.jpg",
// see DisturbPhotos).
std::string KindOfLine(const std::string& line);

// Runs argv to its end. kInterrupted when cancelled, and kMissingDependency
// when it cannot be started; a program that ran and failed is no error.
StatusOr<ChildOutcome> RunForOutcome(const std::vector<std::string>& argv,
                                     const BenchContext& context);

// Hashes of programs as files have them: "a+b".
std::string ProgramsText(const std::set<std::string>& programs);
std::set<std::string> ParsePrograms(const std::string& text);

// An outcome as a file. Reading returns kBadInput when it is missing or
// damaged.
Status WriteOutcome(const std::filesystem::path& path,
                    const ChildOutcome& outcome);
StatusOr<ChildOutcome> ReadOutcome(const std::filesystem::path& path);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_BENCH_CHILD_OUTCOME_H_
