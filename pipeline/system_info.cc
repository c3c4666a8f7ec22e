// SPDX-License-Identifier: BSD-3-Clause

#include "pipeline/system_info.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sched.h>
#include <string>
#include <string_view>
#include <system_error>
#include <thread>
#include <vector>

namespace freegs::pipeline {
namespace {

namespace fs = std::filesystem;

// The number at the start of a one-line file; nothing if there is none ("max").
std::optional<double> ReadNumber(const fs::path& path) {
  std::ifstream file(path);
  double value = 0;
  if (!(file >> value)) return std::nullopt;
  return value;
}

// Where and under which names control groups tell of their memory.
struct GroupFiles {
  const char* controller;  // In /proc/self/cgroup.
  const char* folder;      // The folder of the topmost group.
  const char* limit;
  const char* usage;
  const char* droppable;  // In memory.stat.
};
constexpr GroupFiles kGroupFilesV2 = {
    "", "sys/fs/cgroup", "memory.max", "memory.current", "inactive_file"};
constexpr GroupFiles kGroupFilesV1 = {"memory",
                                      "sys/fs/cgroup/memory",
                                      "memory.limit_in_bytes",
                                      "memory.usage_in_bytes",
                                      "total_inactive_file"};

// Whether a list such as "cpu,cpuacct" names the controller. Version 2 has one
// group for all of them, and an empty list.
bool Names(std::string_view list, std::string_view controller) {
  while (true) {
    const size_t comma = list.find(',');
    if (list.substr(0, comma) == controller) return true;
    if (comma == std::string_view::npos) return false;
    list.remove_prefix(comma + 1);
  }
}

// The path of this process's group below the topmost one. A line of
// /proc/self/cgroup is NUMBER:CONTROLLERS:/PATH.
fs::path OwnGroup(const fs::path& root, std::string_view controller) {
  std::ifstream file(root / "proc" / "self" / "cgroup");
  std::string line;
  while (std::getline(file, line)) {
    const size_t first = line.find(':');
    const size_t second = line.find(':', first + 1);
    if (first == std::string::npos || second == std::string::npos) continue;
    const std::string_view list =
        std::string_view(line).substr(first + 1, second - first - 1);
    if (!Names(list, controller)) continue;
    return fs::path(line.substr(second + 1)).relative_path();
  }
  return {};
}

// The folders of this process's group and of those above it, of which the last
// is root/top. A container may see its own group as the topmost one but be told
// the path from outside, so some of the folders may not be there.
std::vector<fs::path> GroupFolders(const fs::path& root,
                                   const fs::path& top,
                                   std::string_view controller) {
  std::vector<fs::path> folders;
  fs::path group = OwnGroup(root, controller);
  while (true) {
    folders.push_back(root / top / group);
    if (group.empty()) return folders;
    group = group.parent_path();
  }
}

// Lowers *info to what the group of this process and those above it allow.
// Folders that are not there set no limit.
void LimitByGroups(const fs::path& root,
                   const GroupFiles& files,
                   MemoryInfo* info) {
  for (const fs::path& folder :
       GroupFolders(root, files.folder, files.controller)) {
    // v1 writes about 2^63 for no limit.
    const auto limit = ReadNumber(folder / files.limit);
    if (limit && *limit < static_cast<double>(info->total_bytes)) {
      info->total_bytes = std::llround(*limit);
    }
    if (limit && *limit < 1e18) {
      const double used = ReadNumber(folder / files.usage).value_or(0);
      const auto droppable = static_cast<double>(
          NumberAfter(folder / "memory.stat", files.droppable).value_or(0));
      const double left =
          std::clamp(*limit - used + std::min(droppable, used), 0.0, *limit);
      info->available_bytes =
          std::min<int64_t>(info->available_bytes, std::llround(left));
    }
  }
}

// The cores that one group of version 2 allows; nothing if it sets no limit.
std::optional<double> QuotaV2(const fs::path& folder) {
  std::ifstream file(folder / "cpu.max");
  double quota = 0;
  double period = 0;
  if (file >> quota >> period && period > 0 && quota > 0) return quota / period;
  return std::nullopt;
}

std::optional<double> QuotaV1(const fs::path& folder) {
  const auto quota = ReadNumber(folder / "cpu.cfs_quota_us");
  const auto period = ReadNumber(folder / "cpu.cfs_period_us");
  if (quota && period && *quota > 0 && *period > 0) return *quota / *period;
  return std::nullopt;
}

}  // namespace

std::optional<int64_t> NumberAfter(const fs::path& path,
                                   std::string_view name) {
  std::ifstream file(path);
  std::string word;
  while (file >> word) {
    int64_t value = 0;
    if (word == name && file >> value) return value;
  }
  return std::nullopt;
}

int CoresOfAffinity() {
  cpu_set_t set;
  CPU_ZERO(&set);
  if (sched_getaffinity(0, sizeof(set), &set) == 0) {
    return std::max(1, CPU_COUNT(&set));
  }
  return static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
}

std::optional<double> CoresOfQuota() { return CoresOfQuotaIn("/"); }

std::optional<double> CoresOfQuotaIn(const fs::path& root) {
  std::optional<double> least;
  const auto take = [&least](std::optional<double> quota) {
    if (quota && (!least || *quota < *least)) least = quota;
  };
  for (const fs::path& folder : GroupFolders(root, "sys/fs/cgroup", "")) {
    take(QuotaV2(folder));
  }
  for (const fs::path& folder :
       GroupFolders(root, "sys/fs/cgroup/cpu", "cpu")) {
    take(QuotaV1(folder));
  }
  return least;
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

MemoryInfo Memory() { return MemoryOf("/"); }

MemoryInfo MemoryOf(const fs::path& root) {
  MemoryInfo info;
  const fs::path meminfo = root / "proc" / "meminfo";
  constexpr int64_t kUnit = 1024;  // The kernel counts in kilobytes.
  info.total_bytes = NumberAfter(meminfo, "MemTotal:").value_or(0) * kUnit;
  info.available_bytes =
      NumberAfter(meminfo, "MemAvailable:").value_or(0) * kUnit;
  for (const GroupFiles& files : {kGroupFilesV2, kGroupFilesV1}) {
    LimitByGroups(root, files, &info);
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
