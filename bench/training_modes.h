// SPDX-License-Identifier: BSD-3-Clause
// What freegs_training_benchmark can do. Results go to standard output, remarks
// to standard error.

#ifndef FREEGS_BENCH_TRAINING_MODES_H_
#define FREEGS_BENCH_TRAINING_MODES_H_

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/status.h"

namespace freegs::bench {

inline Status NoHoldoutError() {
  return BadInputError(
      "the workspace has no holdout photo to measure quality on; choose some "
      "with ingest.holdout_every");
}

// Time per step at the start of a training without densification, on full-size
// images, from the points of structure from motion.
struct StepsOptions {
  std::filesystem::path workspace;
  int max_image_size = 480;  // Longest side in pixels; 0: the photos' own.
  int threads = 0;           // 0: one per available core.
  int steps = 200;           // Per round.
  int rounds = 3;            // All from the same start.
  int64_t gaussians = 0;     // To start with; 0: one per point.
};
Status RunSteps(const StepsOptions& options);

// Quality on all holdout photos over time, of a training as the reconstruct
// stage does it.
struct CurveOptions {
  std::filesystem::path workspace;
  std::optional<std::string> preset;
  std::optional<int> max_image_size;
  std::optional<int> threads;
  std::vector<std::string> settings;  // "reconstruct.iterations=1000".
  int every = 50;                     // Steps between measurements.
  std::optional<double> until;        // dB to stop at.
};
Status RunCurve(const CurveOptions& options);

// Quality on the holdout photos of a .ply in the frame of the poses.
struct EvaluateOptions {
  std::filesystem::path workspace;
  std::filesystem::path ply;
  int max_image_size = 480;
  int threads = 0;
  std::array<float, 3> background = {0, 0, 0};
};
Status RunEvaluate(const EvaluateOptions& options);

// Writes a COLMAP project of the training photos only: output/images and
// output/sparse/0, neither of which may exist.
struct ExportOptions {
  std::filesystem::path workspace;
  std::filesystem::path output;
};
Status RunExport(const ExportOptions& options);

}  // namespace freegs::bench

#endif  // FREEGS_BENCH_TRAINING_MODES_H_
