// SPDX-License-Identifier: BSD-3-Clause
// The tables of a bench in Markdown.

#ifndef FREEGS_STAGES_BENCH_BENCH_SUMMARY_H_
#define FREEGS_STAGES_BENCH_BENCH_SUMMARY_H_

#include <string>

#include "stages/bench/bench_results.h"

namespace freegs::stages {

// One table for each [table] of the suite, or one of seconds and PSNR when it
// has none, and a list of the cells that failed. A field is the mean over the
// cells of the row and, behind ±, the largest difference from it; "n of m"
// behind it when it is of only some of the cells. Figures are those of the
// cells that are done; in a row without any of these, of all. Means over scenes
// have no ±.
std::string SummaryMarkdown(const BenchResults& bench);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_BENCH_BENCH_SUMMARY_H_
