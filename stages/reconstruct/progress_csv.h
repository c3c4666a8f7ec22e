// SPDX-License-Identifier: BSD-3-Clause
// Writes reconstruct/progress.csv, the course of the training as a table.

#ifndef FREEGS_STAGES_RECONSTRUCT_PROGRESS_CSV_H_
#define FREEGS_STAGES_RECONSTRUCT_PROGRESS_CSV_H_

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "core/status.h"

namespace freegs::stages {

struct ProgressRow {
  int64_t iteration = 0;
  double seconds = 0;  // Since training began, without pauses between runs.
  double loss = 0;     // Mean over the steps since the row before.
  size_t num_gaussians = 0;
  std::optional<double> holdout_psnr;  // dB; nothing where not measured.
};

// Keeps all rows in memory and rewrites the whole file atomically, which is
// cheap: a training has a few hundred rows.
class ProgressCsv {
 public:
  explicit ProgressCsv(std::filesystem::path path) : path_(std::move(path)) {}

  // Begins the file. A training that resumes at `iteration` keeps the rows up
  // to there of the file that an earlier run has left; with 0, or when that
  // file cannot be read, the table begins empty. Writes the file.
  Status Open(int64_t iteration);

  // Adds a row in memory; Flush writes the file.
  void Add(const ProgressRow& row);
  Status Flush() const;

 private:
  std::filesystem::path path_;
  std::string text_;
};

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_RECONSTRUCT_PROGRESS_CSV_H_
