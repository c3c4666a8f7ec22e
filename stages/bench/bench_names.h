// SPDX-License-Identifier: BSD-3-Clause
// The names that charts and tables of a suite use, and whether there is
// anything of such a name.

#ifndef FREEGS_STAGES_BENCH_BENCH_NAMES_H_
#define FREEGS_STAGES_BENCH_BENCH_NAMES_H_

#include <optional>
#include <string>
#include <vector>

#include "stages/bench/bench_results.h"

namespace freegs::stages {

// What a cell has under the name of words, such as "verdict" or "told"; nothing
// when the name is not that of words.
std::optional<std::string> WordsOf(const CellResult& result,
                                   const std::string& name);

// Says of each key in `label`, `series` and `over` that no grid has it:
// "[chart a]: series: there is no key sede; did you mean seed?". This is known
// before anything has run.
std::vector<std::string> UnknownKeys(const Suite& suite);

// Says the same of each figure in `x`, `y` and `columns` that no cell has.
// Empty as long as no cell is done: cells that fail have few figures.
std::vector<std::string> UnknownFigures(const BenchResults& bench);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_BENCH_BENCH_NAMES_H_
