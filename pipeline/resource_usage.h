// SPDX-License-Identifier: BSD-3-Clause
// Measures how much time and memory some work took.

#ifndef FREEGS_PIPELINE_RESOURCE_USAGE_H_
#define FREEGS_PIPELINE_RESOURCE_USAGE_H_

#include <chrono>
#include <cstdint>
#include <string>

namespace freegs::pipeline {

struct ResourceUsage {
  double wall_seconds = 0;
  double cpu_seconds = 0;  // All threads, and child processes that ended.
  int64_t peak_memory_bytes = 0;  // Largest resident size of one process.
};

// The usage of two pieces of work, one after the other: the sums of their
// times, and the larger peak.
ResourceUsage Sum(const ResourceUsage& a, const ResourceUsage& b);

// "12 s (20 s CPU, peak 1.2 GB)".
std::string ToText(const ResourceUsage& usage);

// The resident size of this process now; 0 where the system does not tell.
int64_t ResidentMemoryBytes();

// Whether a meter asks the kernel to reset its record of the peak
// (/proc/self/clear_refs). There is one record for the whole process, so of
// meters within each other only the outermost one, the stage runner's, may do
// so. The others tell the peak since then. Where the kernel refuses, it is that
// of the whole process so far.
enum class PeakMemory : uint8_t { kReset, kKeep };

// Measures the work since its construction.
class ResourceMeter {
 public:
  explicit ResourceMeter(PeakMemory peak = PeakMemory::kKeep);

  ResourceUsage Elapsed() const;

 private:
  std::chrono::steady_clock::time_point start_;
  double start_cpu_seconds_;
  int64_t start_child_peak_bytes_;
};

}  // namespace freegs::pipeline

#endif  // FREEGS_PIPELINE_RESOURCE_USAGE_H_
