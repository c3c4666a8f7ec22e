// SPDX-License-Identifier: BSD-3-Clause
// The cores, memory and disk space that this process may use.

#ifndef FREEGS_PIPELINE_SYSTEM_INFO_H_
#define FREEGS_PIPELINE_SYSTEM_INFO_H_

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string_view>

namespace freegs::pipeline {

// The number that follows a word of a text file, as in /proc and in the folders
// of control groups: "VmRSS:   1204 kB". Nothing when there is none.
std::optional<int64_t> NumberAfter(const std::filesystem::path& path,
                                   std::string_view name);

// The number of cores in the affinity mask of this process.
int CoresOfAffinity();

// The number of cores whose time the control group allows (cpu.max of cgroup v2
// or cpu.cfs_quota_us of v1), which need not be whole; nothing if it sets no
// limit. The groups above that of this process count, too.
std::optional<double> CoresOfQuota();

// What CoresOfQuota returns on a system whose folders proc and sys lie in
// `root`.
std::optional<double> CoresOfQuotaIn(const std::filesystem::path& root);

// How many threads are worth starting: the smaller one of the two numbers
// above, rounded up, but at least 1.
int AvailableCores();

// The number of threads that an option asks for: 0 means one per available
// core.
int WorkingThreads(int option);

struct MemoryInfo {
  int64_t total_bytes = 0;
  int64_t available_bytes = 0;  // Without swapping.
};
// The memory of the machine, or what the control groups of this process
// (memory.max of cgroup v2 or memory.limit_in_bytes of v1) leave of it, if that
// is less. Files in the cache of a group that it can drop count as available.
MemoryInfo Memory();

// What Memory returns on a system whose folders proc and sys lie in `root`.
MemoryInfo MemoryOf(const std::filesystem::path& root);

// Bytes that an ordinary user can still write on the file system of `path`;
// nothing when that cannot be found out.
std::optional<int64_t> FreeDiskBytes(const std::filesystem::path& path);

}  // namespace freegs::pipeline

#endif  // FREEGS_PIPELINE_SYSTEM_INFO_H_
