// SPDX-License-Identifier: BSD-3-Clause
// reconstruct/progress.csv: one row per report of the training.

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
  double seconds = 0;  // Since training began, interruptions not counted.
  double loss = 0;
  size_t num_gaussians = 0;
  std::optional<double> holdout_psnr;  // Empty where not measured.
};

// Rows are kept in memory and the whole file is rewritten atomically: there are
// a few hundred.
class ProgressCsv {
 public:
  explicit ProgressCsv(std::filesystem::path path) : path_(std::move(path)) {}

  // Takes over the rows of an earlier file up to `iteration`, the one training
  // resumes at (0 starts anew). An unreadable file is started anew.
  Status Open(int64_t iteration);

  void Add(const ProgressRow& row);
  Status Flush() const;

 private:
  std::filesystem::path path_;
  std::string text_;
};

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_RECONSTRUCT_PROGRESS_CSV_H_
