// SPDX-License-Identifier: BSD-3-Clause
// A baseline: the figures that an earlier program gave for a suite, and how far
// each may move. Only figures that do not depend on the speed of the machine
// belong there.

#ifndef FREEGS_STAGES_BENCH_BASELINE_H_
#define FREEGS_STAGES_BENCH_BASELINE_H_

#include <map>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "core/status.h"
#include "stages/bench/bench_results.h"

namespace freegs::stages {

// A figure may differ by absolute + relative * |what it was|.
struct Tolerance {
  double absolute = 0;
  double relative = 0;
};

struct BaselineCell {
  std::string status;
  int exit_code = 0;
  std::string verdict;
  std::map<std::string, double> values;

  bool operator==(const BaselineCell&) const = default;
};

struct Baseline {
  std::map<std::string, Tolerance> tolerances;  // By the name of the figure.
  std::map<std::string, BaselineCell> cells;    // By the cell's id.
};

// The tolerances of a new baseline. What accuracies differ by between sets of
// SIMD instructions lies within them (docs/bench.md).
std::map<std::string, Tolerance> DefaultTolerances();

// The baseline of these results, with the figures that `tolerances` name.
Baseline MakeBaseline(const BenchResults& bench,
                      std::map<std::string, Tolerance> tolerances);

// kUnusableResult when a cell ended with an exit code that tells of a fault of
// the machine (1, 5, or -1 for a signal or the time limit). Such results are no
// baseline, because the next bench may end otherwise.
Status CheckForBaseline(const BenchResults& bench);

// One line for each cell or figure that moved further than it may, that is new,
// or that is gone; none when all is as it was.
std::vector<std::string> WhatMoved(const Baseline& then, const Baseline& now);

nlohmann::json ToJson(const Baseline& baseline);

// kBadInput names `source` and the entry that is wrong.
StatusOr<Baseline> BaselineFromJson(const nlohmann::json& json,
                                    const std::string& source);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_BENCH_BASELINE_H_
