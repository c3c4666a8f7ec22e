// SPDX-License-Identifier: BSD-3-Clause
// Runs the cells of a suite, one after the other or several at a time.

#ifndef FREEGS_STAGES_BENCH_CELL_RUNNER_H_
#define FREEGS_STAGES_BENCH_CELL_RUNNER_H_

#include <functional>
#include <vector>

#include "core/status.h"
#include "stages/bench/bench_context.h"
#include "stages/bench/cell_result.h"
#include "stages/bench/stage_store.h"
#include "stages/suite/suite_cells.h"

namespace freegs::stages {

struct CellRunnerOptions {
  int jobs = 1;  // Cells at a time.

  // Called after each cell with all results so far, one call at a time.
  std::function<Status(const std::vector<CellResult>&)> finished;
};

// The photographs of all scenes, in their order.
StatusOr<std::vector<ScenePhotos>> FindAllPhotos(const Suite& suite,
                                                 const BenchContext& context);

// Runs the cells and returns their results in the same order. A cell that fails
// is a result. Errors, after which what is done is kept: kInterrupted, a disk
// that cannot be written to, and a program that is built anew while only its
// results count.
StatusOr<std::vector<CellResult>> RunCells(
    const Suite& suite,
    const std::vector<SuiteCell>& cells,
    const std::vector<ScenePhotos>& photos,
    const BenchContext& context,
    const CellRunnerOptions& options);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_BENCH_CELL_RUNNER_H_
