// SPDX-License-Identifier: BSD-3-Clause

#include "pipeline/system_info.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sched.h>
#include <string>
#include <system_error>
#include <thread>

namespace freegs::pipeline {
namespace {

namespace fs = std::filesystem;

// The number at the start of a one-line file; nothing if there is none ("max").
std::optional<double> ReadNumber(const char* path) {
  std::ifstream file(path);
  double value = 0;
  if (!(file >> value)) return std::nullopt;
  return value;
}

}  // namespace

int CoresOfAffinity() {
  cpu_set_t set;
  CPU_ZERO(&set);
  if (sched_getaffinity(0, sizeof(set), &set) == 0) {
    return std::max(1, CPU_COUNT(&set));
  }
  return static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
}

std::optional<double> CoresOfQuota() {
  std::ifstream v2("/sys/fs/cgroup/cpu.max");
  double quota = 0;
  double period = 0;
  if (v2 >> quota >> period && period > 0 && quota > 0) return quota / period;
  const auto v1_quota = ReadNumber("/sys/fs/cgroup/cpu/cpu.cfs_quota_us");
  const auto v1_period = ReadNumber("/sys/fs/cgroup/cpu/cpu.cfs_period_us");
  if (v1_quota && v1_period && *v1_quota > 0 && *v1_period > 0) {
    return *v1_quota / *v1_period;
  }
  return std::nullopt;
}

int AvailableCores() {
  int cores = CoresOfAffinity();
  if (const std::optional<double> quota = CoresOfQuota()) {
    cores = std::min(cores, static_cast<int>(std::ceil(*quota)));
  }
  return std::max(1, cores);
}

int WorkingThreads(int option) {
  return option > 0 ? option : AvailableCores();
}

MemoryInfo Memory() {
  MemoryInfo info;
  std::ifstream meminfo("/proc/meminfo");
  std::string word;
  while (meminfo >> word) {
    int64_t kilobytes = 0;
    if (word == "MemTotal:" && meminfo >> kilobytes) {
      info.total_bytes = kilobytes * 1024;
    } else if (word == "MemAvailable:" && meminfo >> kilobytes) {
      info.available_bytes = kilobytes * 1024;
    }
  }
  auto limit = ReadNumber("/sys/fs/cgroup/memory.max");
  auto used = ReadNumber("/sys/fs/cgroup/memory.current");
  if (!limit) {
    limit = ReadNumber("/sys/fs/cgroup/memory/memory.limit_in_bytes");
    used = ReadNumber("/sys/fs/cgroup/memory/memory.usage_in_bytes");
  }
  if (limit && *limit < static_cast<double>(info.total_bytes)) {
    info.total_bytes = std::llround(*limit);
    info.available_bytes =
        std::min(info.available_bytes,
                 std::max<int64_t>(0, std::llround(*limit - used.value_or(0))));
  }
  return info;
}

std::optional<int64_t> FreeDiskBytes(const fs::path& path) {
  std::error_code error;
  const fs::space_info space = fs::space(path, error);
  if (error) return std::nullopt;
  return static_cast<int64_t>(space.available);
}

}  // namespace freegs::pipeline
