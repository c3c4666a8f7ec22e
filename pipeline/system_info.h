// SPDX-License-Identifier: BSD-3-Clause
// What the machine offers to this process.

#ifndef FREEGS_PIPELINE_SYSTEM_INFO_H_
#define FREEGS_PIPELINE_SYSTEM_INFO_H_

#include <cstdint>
#include <filesystem>
#include <optional>

namespace freegs::pipeline {

// Cores this process may run on (its affinity mask).
int CoresOfAffinity();

// Cores' worth of time the control group allows (cgroup v2 cpu.max or v1
// cpu.cfs_quota_us); nothing if it sets no limit.
std::optional<double> CoresOfQuota();

// How many threads are worth starting: the smaller of both, rounded up, at
// least 1.
int AvailableCores();

struct MemoryInfo {
  int64_t total_bytes = 0;
  int64_t available_bytes = 0;  // Without swapping.
};
// The machine's memory, cut to the control group's limit.
MemoryInfo Memory();

// Free bytes for an ordinary user on the file system that holds `path`.
std::optional<int64_t> FreeDiskBytes(const std::filesystem::path& path);

}  // namespace freegs::pipeline

#endif  // FREEGS_PIPELINE_SYSTEM_INFO_H_
