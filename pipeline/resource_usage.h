// SPDX-License-Identifier: BSD-3-Clause
// How much time and memory a stretch of work took.

#ifndef FREEGS_PIPELINE_RESOURCE_USAGE_H_
#define FREEGS_PIPELINE_RESOURCE_USAGE_H_

#include <chrono>
#include <cstdint>

namespace freegs::pipeline {

struct ResourceUsage {
  double wall_seconds = 0;
  double cpu_seconds = 0;  // All threads, and child processes that ended.
  int64_t peak_memory_bytes = 0;  // Largest resident size of one process.
};

// Measures from its construction on.
class ResourceMeter {
 public:
  // Asks the kernel to start its record of the peak anew
  // (/proc/self/clear_refs); where that is refused the peak is the process's.
  ResourceMeter();

  ResourceUsage Elapsed() const;

 private:
  std::chrono::steady_clock::time_point start_;
  double start_cpu_seconds_;
  int64_t start_child_peak_bytes_;
};

}  // namespace freegs::pipeline

#endif  // FREEGS_PIPELINE_RESOURCE_USAGE_H_
