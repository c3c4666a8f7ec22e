// SPDX-License-Identifier: BSD-3-Clause
// How many threads are worth starting, and how much memory there is.

#include "pipeline/system_info.h"

#include <cmath>
#include <optional>

#include <gtest/gtest.h>

#include "tests/temporary_folder.h"

namespace freegs::pipeline {
namespace {

TEST(SystemInfoTest, AvailableCoresKeepToTheControlGroup) {
  EXPECT_GE(AvailableCores(), 1);
  EXPECT_LE(AvailableCores(), CoresOfAffinity());
  if (const auto quota = CoresOfQuota()) {
    EXPECT_LE(AvailableCores(), std::ceil(*quota));
  }
}

TEST(SystemInfoTest, TheTightestQuotaOfTheGroupsAboveCounts) {
  const TemporaryFolder root;
  EXPECT_EQ(CoresOfQuotaIn(root.path()), std::nullopt);
  root.Write("proc/self/cgroup", "0::/user.slice/run.scope\n");
  const std::string top = "sys/fs/cgroup/";
  root.Write(top + "user.slice/run.scope/cpu.max", "max 100000\n");
  EXPECT_EQ(CoresOfQuotaIn(root.path()), std::nullopt);
  root.Write(top + "user.slice/cpu.max", "300000 100000\n");
  EXPECT_EQ(CoresOfQuotaIn(root.path()), 3);
  root.Write(top + "user.slice/run.scope/cpu.max", "150000 100000\n");
  EXPECT_EQ(CoresOfQuotaIn(root.path()), 1.5);
  // Seen from inside a container the group is the topmost folder.
  root.Write(top + "cpu.max", "50000 100000\n");
  EXPECT_EQ(CoresOfQuotaIn(root.path()), 0.5);
  // The quota of another process does not count.
  root.Write(top + "user.slice/other.scope/cpu.max", "10000 100000\n");
  EXPECT_EQ(CoresOfQuotaIn(root.path()), 0.5);
}

TEST(SystemInfoTest, QuotasOfGroupsV1Count) {
  const TemporaryFolder root;
  root.Write("proc/self/cgroup",
             "7:cpuset:/b\n6:cpu,cpuacct:/docker/12\n5:memory:/a\n");
  const std::string top = "sys/fs/cgroup/cpu/";
  root.Write(top + "cpu.cfs_quota_us", "-1\n");
  root.Write(top + "cpu.cfs_period_us", "100000\n");
  root.Write(top + "b/cpu.cfs_quota_us", "10000\n");
  root.Write(top + "b/cpu.cfs_period_us", "100000\n");
  EXPECT_EQ(CoresOfQuotaIn(root.path()), std::nullopt);
  root.Write(top + "docker/12/cpu.cfs_quota_us", "250000\n");
  root.Write(top + "docker/12/cpu.cfs_period_us", "100000\n");
  EXPECT_EQ(CoresOfQuotaIn(root.path()), 2.5);
}

TEST(SystemInfoTest, AnOptionOfNoughtTakesTheAvailableCores) {
  EXPECT_EQ(WorkingThreads(0), AvailableCores());
  EXPECT_EQ(WorkingThreads(3), 3);
}

TEST(SystemInfoTest, NumbersAreFoundByTheWordBeforeThem) {
  const TemporaryFolder folder;
  folder.Write("status", "Name: a 7\nVmRSS:\t  1204 kB\nVmHWM: none\n");
  EXPECT_EQ(NumberAfter(folder / "status", "VmRSS:"), 1204);
  EXPECT_EQ(NumberAfter(folder / "status", "VmHWM:"), std::nullopt);
  EXPECT_EQ(NumberAfter(folder / "status", "VmPeak:"), std::nullopt);
  EXPECT_EQ(NumberAfter(folder / "missing", "VmRSS:"), std::nullopt);
}

// A machine with 8000 kB, of which 6000 kB are available.
class MemoryTest : public ::testing::Test {
 protected:
  MemoryTest() {
    Write("proc/meminfo",
          "MemTotal:       8000 kB\nMemFree: 500 kB\n"
          "MemAvailable:   6000 kB\n");
  }

  void Write(const std::string& path, const std::string& text) {
    WriteText(folder_ / path, text);
  }

  void ExpectMemory(int64_t total_kb, int64_t available_kb) {
    const MemoryInfo info = MemoryOf(folder_.path());
    EXPECT_EQ(info.total_bytes, total_kb * 1024);
    EXPECT_EQ(info.available_bytes, available_kb * 1024);
  }

  TemporaryFolder folder_;
};

TEST_F(MemoryTest, IsThatOfTheMachineWithoutGroups) {
  ExpectMemory(8000, 6000);
}

TEST_F(MemoryTest, IsNoughtWhereNothingIsTold) {
  const TemporaryFolder empty;
  EXPECT_EQ(MemoryOf(empty.path()).total_bytes, 0);
  EXPECT_EQ(MemoryOf(empty.path()).available_bytes, 0);
}

TEST_F(MemoryTest, KeepsToTheLimitOfAGroupV2) {
  Write("proc/self/cgroup", "0::/\n");
  Write("sys/fs/cgroup/memory.max", "2048000\n");  // 2000 kB.
  Write("sys/fs/cgroup/memory.current", "1536000\n");
  ExpectMemory(2000, 500);
  // Files in the cache make room when it is needed.
  Write("sys/fs/cgroup/memory.stat", "anon 1\ninactive_file 1024000\n");
  ExpectMemory(2000, 1500);
  // The machine may have less than the limit leaves.
  Write("proc/meminfo", "MemTotal: 8000 kB\nMemAvailable: 300 kB\n");
  ExpectMemory(2000, 300);
}

TEST_F(MemoryTest, AGroupV2WithoutALimitLimitsNothing) {
  Write("sys/fs/cgroup/memory.max", "max\n");
  Write("sys/fs/cgroup/memory.current", "1536000\n");
  ExpectMemory(8000, 6000);
}

TEST_F(MemoryTest, KeepsToTheTightestOfTheGroupsAboveIt) {
  Write("proc/self/cgroup", "0::/user.slice/run.scope\n");
  Write("sys/fs/cgroup/user.slice/memory.max", "2048000\n");
  Write("sys/fs/cgroup/user.slice/memory.current", "1024000\n");
  Write("sys/fs/cgroup/user.slice/run.scope/memory.max", "max\n");
  ExpectMemory(2000, 1000);
  Write("sys/fs/cgroup/user.slice/run.scope/memory.max", "512000\n");
  Write("sys/fs/cgroup/user.slice/run.scope/memory.current", "102400\n");
  ExpectMemory(500, 400);
}

TEST_F(MemoryTest, KeepsToTheLimitOfAGroupV1) {
  Write("proc/self/cgroup", "7:cpu,cpuacct:/a\n5:memory:/docker/12\n");
  const std::string top = "sys/fs/cgroup/memory/";
  Write(top + "memory.limit_in_bytes", "9223372036854771712\n");
  Write(top + "memory.usage_in_bytes", "4096000\n");
  ExpectMemory(8000, 6000);
  // Seen from inside the container the group is the topmost folder.
  Write(top + "memory.limit_in_bytes", "2048000\n");
  Write(top + "memory.usage_in_bytes", "1536000\n");
  Write(top + "memory.stat", "total_inactive_file 102400\n");
  ExpectMemory(2000, 600);
}

TEST_F(MemoryTest, AGroupThatIsFullLeavesNothing) {
  Write("sys/fs/cgroup/memory.max", "1024000\n");
  Write("sys/fs/cgroup/memory.current", "1100000\n");
  ExpectMemory(1000, 0);
}

}  // namespace
}  // namespace freegs::pipeline
