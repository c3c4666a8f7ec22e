// SPDX-License-Identifier: BSD-3-Clause
// What one cell of a bench gave.

#ifndef FREEGS_STAGES_BENCH_CELL_RESULT_H_
#define FREEGS_STAGES_BENCH_CELL_RESULT_H_

#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "core/status.h"
#include "stages/suite/suite_cells.h"

namespace freegs::stages {

enum class CellStatus { kWaiting, kDone, kFailed };

// A warning or an error that the user was told.
struct SaidLine {
  std::string stage;
  std::string text;
};

struct CellResult {
  CellStatus status = CellStatus::kWaiting;

  // How it failed: the exit code of the stage (or of eval), which it was, and
  // why.
  int exit_code = 0;
  std::string failed_stage;
  std::string reason;

  // The verdict of structure from motion: ok, degraded or failed.
  std::string verdict;

  // By their order; of more than ten of a stage the first and the last five.
  std::vector<SaidLine> said;

  // The first line of each kind of each stage, by their order (KindOfLine).
  std::vector<SaidLine> kinds;

  // The first of these that the cells of the reference were not told; empty
  // where there is none. See CompareWithReference.
  SaidLine told;

  // Figures by name: "holdout_psnr" and all others of eval, and of each stage
  // "STAGE.wall_seconds", "STAGE.cpu_seconds", "STAGE.peak_memory_bytes",
  // "STAGE.bytes" (on disk), and what it reports: "reconstruct.num_gaussians".
  // "total." has the sums over the stages, and the largest peak. scene_bytes is
  // the size of the trained scene's file. "kept." has figures of eval in
  // percent of the reference's.
  std::map<std::string, double> values;

  std::string folder;  // The cell's workspace, relative to OUT.
  std::string log;     // The log of the last stage that ran, relative to OUT.

  // Hashes of the programs that its results are of.
  std::set<std::string> programs;
};

const char* CellStatusName(CellStatus status);

// How it ended, in words: "done", "sfm: exit code 4".
std::string EndedText(const CellResult& result);

// Adds the figures of a stage in a workspace, finished or failed, and the
// verdict.
void AddStageFigures(const std::filesystem::path& workspace,
                     const std::string& stage,
                     CellResult* result);

// Adds the figures of eval --json.
Status AddEvaluation(const std::filesystem::path& file, CellResult* result);

// Everything about a cell, for results.json.
nlohmann::json ToJson(const Suite& suite,
                      const SuiteCell& cell,
                      const CellResult& result);

// The value of a key of a cell as text: scene, grid, seed, or a key of its
// grid. Empty where its grid does not have the key.
std::string KeyText(const Suite& suite,
                    const SuiteCell& cell,
                    const std::string& key);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_BENCH_CELL_RESULT_H_
