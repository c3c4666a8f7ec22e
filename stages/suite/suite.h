// SPDX-License-Identifier: BSD-3-Clause
// A suite of experiments: scenes, options to vary, seeds, and what is to be
// seen of the results. docs/bench.md describes the file.

#ifndef FREEGS_STAGES_SUITE_SUITE_H_
#define FREEGS_STAGES_SUITE_SUITE_H_

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/status.h"

namespace freegs::stages {

// An option and its value as the suite gives it: "reconstruct.iterations".
using SuiteSetting = std::pair<std::string, std::string>;

// One set of photographs. Either `images` or `draw` is given.
struct SuiteScene {
  std::string name;
  std::filesystem::path images;   // A folder or a film; absolute.
  std::filesystem::path truth;    // For eval --gt; empty when there is none.
  std::vector<std::string> draw;  // The arguments of freegs_make_scene.
  std::vector<SuiteSetting> settings;
};

// The options that are varied: a cell for each combination of their values.
struct SuiteGrid {
  std::string name;
  std::vector<std::pair<std::string, std::vector<std::string>>> axes;
  std::vector<int64_t> seeds = {};  // Empty for the suite's.
};

// What all charts and tables choose from the cells.
struct SuiteSelection {
  std::string name;
  std::string title;

  // Only these scenes and grids; empty for all.
  std::vector<std::string> scenes;
  std::vector<std::string> grids;

  // The keys over which means are taken: seed, scene, or the key of a grid.
  std::vector<std::string> over = {"seed"};
};

// One measure against another.
struct SuiteChart : SuiteSelection {
  std::string x;
  std::string y;

  // Points are of one series where these keys agree.
  std::vector<std::string> series = {"scene"};

  // The key whose value stands beside a point; may be empty.
  std::string label;
  bool log_x = false;
  bool log_y = false;

  // "higher" or "lower": which value of y is better; empty: by its name.
  std::string better;
};

// Measures side by side.
struct SuiteTable : SuiteSelection {
  std::vector<std::string> columns;

  // Rows below the others: the mean over some scenes, by their title.
  std::vector<std::pair<std::string, std::vector<std::string>>> means;
};

struct Suite {
  std::string name;  // The file's, without .ini.
  std::string title;
  std::filesystem::path folder;  // Where relative paths start; absolute.
  std::vector<int64_t> seeds = {1};
  std::string to = "bootstrap";  // The last stage.
  double time_limit_s = 0;       // Limit of each stage; 0 for none.

  // The grid with which all others are compared; empty for none.
  std::string reference;
  std::vector<SuiteSetting> settings;
  std::vector<SuiteScene> scenes;
  std::vector<SuiteGrid> grids;
  std::vector<SuiteChart> charts;
  std::vector<SuiteTable> tables;
};

// Reads a suite; `source` is its file, for names and messages. Variables are
// those of the environment; ${scene}, which a setting may name, is left for
// later (suite_cells.h). kInvalidArgument names the file, the section and the
// fault. Whether options exist and photographs are there is not looked at.
StatusOr<Suite> ParseSuite(const std::string& text,
                           const std::filesystem::path& source);
StatusOr<Suite> ReadSuite(const std::filesystem::path& path);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_SUITE_SUITE_H_
