// SPDX-License-Identifier: BSD-3-Clause
// The experiments of a suite, one by one: each scene with each point of each
// grid and each seed.

#ifndef FREEGS_STAGES_SUITE_SUITE_CELLS_H_
#define FREEGS_STAGES_SUITE_SUITE_CELLS_H_

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "core/status.h"
#include "stages/suite/suite.h"

namespace freegs::stages {

struct SuiteCell {
  size_t scene = 0;  // Index in Suite::scenes.
  std::string grid;
  int64_t seed = 0;

  // What the grid says of it, as the suite writes it: {"preset", "fast"}.
  std::vector<SuiteSetting> point;

  // Everything that is set, by the full names of options; ${scene} is still in
  // the values. The suite's come first, then the scene's, then the grid's.
  std::vector<SuiteSetting> settings;

  // Options of command eval by their names there: {"text-from", "gaussians"};
  // ${scene} is still in the values.
  std::map<std::string, std::string> eval_options;

  // What is done to the photographs; empty for nothing.
  std::string disturb;

  // "fox, grid sizes: preset=fast, seed 1": no other cell of the suite has it.
  std::string id;
};

// How keys are checked that are not options of the pipeline. An empty function
// makes its keys unknown.
struct SuiteChecks {
  // "eval.KEY": an option of command eval. Returns whether its value is a path.
  std::function<StatusOr<bool>(const std::string& option,
                               const std::string& value)>
      eval;

  // "disturb": what is done to photographs.
  std::function<Status(const std::string& value)> disturb;
};

// Returns at least one and at most 10000 cells, seeds within points within
// grids within scenes. kInvalidArgument names the section and the option that
// is unknown or out of range. Relative paths in options start at the suite's
// folder.
StatusOr<std::vector<SuiteCell>> MakeCells(const Suite& suite,
                                           const SuiteChecks& checks);

// The keys of the suite's grids, in the order in which they first appear.
std::vector<std::string> GridKeys(const Suite& suite);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_SUITE_SUITE_CELLS_H_
