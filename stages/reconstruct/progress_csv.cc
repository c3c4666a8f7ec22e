// SPDX-License-Identifier: BSD-3-Clause

#include "stages/reconstruct/progress_csv.h"

#include <cstdio>
#include <cstdlib>
#include <sstream>

#include "core/io/files.h"

namespace freegs::stages {
namespace {

constexpr char kHeader[] =
    "iteration,seconds,loss,num_gaussians,holdout_psnr\n";

}  // namespace

Status ProgressCsv::Open(int64_t iteration) {
  text_ = kHeader;
  if (iteration > 0) {
    const StatusOr<std::string> earlier = ReadFile(path_);
    if (earlier.ok()) {
      std::istringstream lines(*earlier);
      std::string line;
      std::getline(lines, line);
      while (std::getline(lines, line)) {
        const int64_t row = std::strtoll(line.c_str(), nullptr, 10);
        if (row > 0 && row <= iteration) text_ += line + "\n";
      }
    }
  }
  return Flush();
}

void ProgressCsv::Add(const ProgressRow& row) {
  char line[128];
  std::snprintf(line,
                sizeof(line),
                "%lld,%.3f,%.6f,%zu,",
                static_cast<long long>(row.iteration),
                row.seconds,
                row.loss,
                row.num_gaussians);
  text_ += line;
  if (row.holdout_psnr) {
    std::snprintf(line, sizeof(line), "%.4f", *row.holdout_psnr);
    text_ += line;
  }
  text_ += "\n";
}

Status ProgressCsv::Flush() const { return WriteFileAtomic(path_, text_); }

}  // namespace freegs::stages
