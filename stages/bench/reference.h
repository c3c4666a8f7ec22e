// SPDX-License-Identifier: BSD-3-Clause
// Compares all cells of a suite with those of its reference grid: what accuracy
// they kept, and what the user was told besides.

#ifndef FREEGS_STAGES_BENCH_REFERENCE_H_
#define FREEGS_STAGES_BENCH_REFERENCE_H_

#include <vector>

#include "stages/bench/cell_result.h"
#include "stages/suite/suite_cells.h"

namespace freegs::stages {

inline constexpr char kKeptPrefix[] = "kept.";

// Sets `told` of all results, and the figures "kept.FIGURE": each figure of
// eval that is a measure of accuracy, in percent of the mean over the reference
// cells of the same scene. A line of the same kind as one of the reference's
// (KindOfLine) is not new. Without a reference `told` is the first line, and
// there are no such figures. `results` are in the order of `cells`.
void CompareWithReference(const Suite& suite,
                          const std::vector<SuiteCell>& cells,
                          std::vector<CellResult>* results);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_BENCH_REFERENCE_H_
