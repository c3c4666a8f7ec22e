// SPDX-License-Identifier: BSD-3-Clause
// What stages are going to need of the machine.

#ifndef FREEGS_PIPELINE_FORECAST_STAGE_NEED_H_
#define FREEGS_PIPELINE_FORECAST_STAGE_NEED_H_

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace freegs::pipeline {

// What the program takes in any stage: itself, the libraries it is linked with
// (OpenCV above all), and what it reads and writes in passing.
inline constexpr int64_t kProgramMemory = 95'000'000;

struct StageNeed {
  // Resident bytes of its largest process at the peak; 0 when nothing is known.
  int64_t memory_bytes = 0;

  int64_t disk_bytes = 0;  // Size of its folder, at most.
  double seconds = 0;

  // The options to change when that is too much, in words that follow "To need
  // less, ".
  std::string advice = {};

  // Why nothing is known, where that can be said; empty when something is
  // known.
  std::string unknown_reason = {};

  // Whether all stages before are done, so that this rests on their files.
  bool from_files = false;

  bool known() const { return memory_bytes > 0; }
};

// "needs about 850 MB of memory, 2 GB are available"; a warning with advice
// when they are less.
std::string MemoryText(const StageNeed& need, int64_t available_bytes);

// The seconds on several threads of what takes so many on one. The share
// `serial` of it is not divided among threads.
double OnThreads(double seconds, double serial, int threads);

// A stage of a run that is to come.
struct StageForecast {
  std::string stage;
  bool needed = true;
  std::string reason = {};  // Why it is needed, or is not brought up to date.
  StageNeed need = {};      // What its Run needs, also when it is not needed.
  // An interrupted run left a part of it, so that less than `need` is left.
  bool begun = false;
};

// What the needed stages take together: the seconds and bytes on disk of all,
// and the memory of the largest.
struct RunNeed {
  StageNeed sum = {};
  // The needed stages of which nothing is known.
  std::vector<std::string> unknown = {};
};
RunNeed Total(std::span<const StageForecast> stages);

// "expected to take about 4 min 20 s, 850 MB of memory and 310 MB of disk
// space; nothing is known of sfm". Empty when no stage is needed.
std::string RunNeedText(const RunNeed& need);

}  // namespace freegs::pipeline

#endif  // FREEGS_PIPELINE_FORECAST_STAGE_NEED_H_
