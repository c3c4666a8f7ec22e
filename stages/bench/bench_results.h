// SPDX-License-Identifier: BSD-3-Clause
// The results of a bench as results.json and results.csv.

#ifndef FREEGS_STAGES_BENCH_BENCH_RESULTS_H_
#define FREEGS_STAGES_BENCH_BENCH_RESULTS_H_

#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "stages/bench/cell_result.h"
#include "stages/suite/suite_cells.h"

namespace freegs::stages {

// A suite and what came out of it; `results` are in the order of `cells`.
struct BenchResults {
  const Suite& suite;
  const std::vector<SuiteCell>& cells;
  const std::vector<CellResult>& results;
};

// The names of all figures that some cell has, sorted.
std::vector<std::string> FigureNames(const BenchResults& bench);

// Whether all cells came from one build of the program.
bool IsOfOneProgram(const BenchResults& bench);

// Title, machine, keys, charts, tables and all cells, with all their figures.
nlohmann::json ToJson(const BenchResults& bench);

// One row for each cell: scene, grid, seed, the keys of the grids, how it
// ended, all figures (RFC 4180).
std::string ToCsv(const BenchResults& bench);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_BENCH_BENCH_RESULTS_H_
