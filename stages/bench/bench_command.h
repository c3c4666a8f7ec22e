// SPDX-License-Identifier: BSD-3-Clause
// `freegs_pipeline bench SUITE.ini --out DIR`: runs a suite of experiments, and
// shows what came out in tables and charts (docs/bench.md). It calls the
// program for each stage, so it knows nothing of the other commands.

#ifndef FREEGS_STAGES_BENCH_BENCH_COMMAND_H_
#define FREEGS_STAGES_BENCH_BENCH_COMMAND_H_

#include <functional>
#include <ostream>
#include <string>
#include <vector>

#include "core/cancellation.h"
#include "core/status.h"
#include "stages/bench/bench_context.h"
#include "stages/command_line/command_words.h"

namespace freegs::stages {

struct BenchEnvironment {
  std::ostream& out;  // The summary.
  std::ostream& err;  // Progress.
  const CancellationToken& cancellation;

  // The words of command eval, to check the keys "eval.OPTION".
  std::function<CommandWords()> eval_words;

  Disturber disturber;
};

CommandWords BenchWords();

// kUnusableResult when no cell is done, or when a figure moved beyond what the
// baseline allows. Cells that failed are no error otherwise.
Status RunBench(const std::vector<std::string>& arguments,
                const BenchEnvironment& environment);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_BENCH_BENCH_COMMAND_H_
