// SPDX-License-Identifier: BSD-3-Clause
// What all parts of a bench are given.

#ifndef FREEGS_STAGES_BENCH_BENCH_CONTEXT_H_
#define FREEGS_STAGES_BENCH_BENCH_CONTEXT_H_

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "core/cancellation.h"
#include "core/status.h"

namespace freegs::stages {

// Disturbs photographs or camera poses, for the key "disturb". All empty: the
// key is unknown.
struct Disturber {
  // Says whether it understands a text such as "blur:2".
  std::function<Status(const std::string& text)> check;

  // Whether poses are disturbed, and not photographs.
  std::function<bool(const std::string& text)> changes_poses;

  // Writes the disturbed photographs of folder `source`, or the disturbed
  // COLMAP model of that folder, into the new folder `out`. kInterrupted when
  // the bench is cancelled.
  std::function<Status(const std::string& text,
                       const std::filesystem::path& source,
                       const std::filesystem::path& out,
                       uint64_t seed)>
      disturb;
};

struct BenchContext {
  std::filesystem::path out;      // The bench's folder; exists.
  std::filesystem::path program;  // freegs_pipeline, which runs the stages.
  double time_limit_s = 0;        // Limit of each stage; 0 for none.

  // Whether results of another build of the program, and those that rest on
  // them, are measured anew.
  bool only_this_program = false;
  Disturber disturber;
  const CancellationToken* cancellation = nullptr;

  // Tells the user what goes on. Several threads call it.
  std::function<void(const std::string&)> say;
};

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_BENCH_BENCH_CONTEXT_H_
