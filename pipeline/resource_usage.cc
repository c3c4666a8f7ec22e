// SPDX-License-Identifier: BSD-3-Clause

#include "pipeline/resource_usage.h"

#include <algorithm>
#include <fstream>
#include <string_view>
#include <sys/resource.h>

#include "core/number_text.h"
#include "pipeline/system_info.h"

namespace freegs::pipeline {
namespace {

double Seconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) +
         1e-6 * static_cast<double>(time.tv_usec);
}

double CpuSeconds() {
  double seconds = 0;
  for (const int who : {RUSAGE_SELF, RUSAGE_CHILDREN}) {
    rusage usage = {};
    getrusage(who, &usage);
    seconds += Seconds(usage.ru_utime) + Seconds(usage.ru_stime);
  }
  return seconds;
}

// Largest resident size of any child so far.
int64_t ChildPeakBytes() {
  rusage usage = {};
  getrusage(RUSAGE_CHILDREN, &usage);
  return int64_t{usage.ru_maxrss} * 1024;
}

// A size that the kernel tells of this process; 0 where it does not.
int64_t StatusBytes(std::string_view name) {
  return NumberAfter("/proc/self/status", name).value_or(0) * 1024;
}

// The peak since the kernel last reset it.
int64_t PeakSinceReset() {
  if (const int64_t peak = StatusBytes("VmHWM:"); peak > 0) return peak;
  rusage usage = {};
  getrusage(RUSAGE_SELF, &usage);
  return int64_t{usage.ru_maxrss} * 1024;
}

}  // namespace

ResourceUsage Sum(const ResourceUsage& a, const ResourceUsage& b) {
  return {a.wall_seconds + b.wall_seconds,
          a.cpu_seconds + b.cpu_seconds,
          std::max(a.peak_memory_bytes, b.peak_memory_bytes)};
}

std::string ToText(const ResourceUsage& usage) {
  return FormatSeconds(usage.wall_seconds) + " (" +
         FormatSeconds(usage.cpu_seconds) + " CPU, peak " +
         FormatBytes(static_cast<double>(usage.peak_memory_bytes)) + ")";
}

int64_t ResidentMemoryBytes() { return StatusBytes("VmRSS:"); }

ResourceMeter::ResourceMeter(PeakMemory peak)
    : start_(std::chrono::steady_clock::now()),
      start_cpu_seconds_(CpuSeconds()),
      start_child_peak_bytes_(ChildPeakBytes()) {
  if (peak == PeakMemory::kReset) std::ofstream("/proc/self/clear_refs") << "5";
}

ResourceUsage ResourceMeter::Elapsed() const {
  ResourceUsage usage;
  usage.wall_seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start_)
          .count();
  usage.cpu_seconds = CpuSeconds() - start_cpu_seconds_;
  usage.peak_memory_bytes = PeakSinceReset();
  // The children's peak cannot be reset: it tells about this stretch only if
  // it grew.
  const int64_t child_peak = ChildPeakBytes();
  if (child_peak > start_child_peak_bytes_) {
    usage.peak_memory_bytes = std::max(usage.peak_memory_bytes, child_peak);
  }
  return usage;
}

}  // namespace freegs::pipeline
