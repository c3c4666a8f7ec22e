// SPDX-License-Identifier: BSD-3-Clause
// Paths, memory and lock of a workspace; signals; what a machine offers.

#include "pipeline/workspace.h"

#include <csignal>
#include <filesystem>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pipeline/exit_code.h"
#include "pipeline/interrupt.h"
#include "pipeline/resource_usage.h"
#include "pipeline/system_info.h"
#include "tests/temporary_folder.h"

namespace freegs::pipeline {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

TEST(AbsolutePathTest, ParentsOfLinksAreThoseOfTheirTargets) {
  EXPECT_EQ(AbsolutePath("a/./b"), fs::current_path() / "a" / "b");
  EXPECT_EQ(AbsolutePath("/no such/../b/"), "/b/");
  const TemporaryFolder folder;
  const fs::path root = fs::canonical(folder.path());
  fs::create_directories(root / "far" / "deep");
  fs::create_directory_symlink("far/deep", root / "link");
  fs::create_directory_symlink("nowhere", root / "dangling");
  EXPECT_EQ(AbsolutePath(root / "link" / "b"), root / "link" / "b");
  EXPECT_EQ(AbsolutePath(root / "link" / ".." / "b"), root / "far" / "b");
  EXPECT_EQ(AbsolutePath(root / "link" / ".." / ".." / "link"), root / "link");
  EXPECT_EQ(AbsolutePath(root / "far" / ".." / "link" / "b"),
            root / "link" / "b");
  EXPECT_EQ(AbsolutePath(root / "far" / ".."), root);
  EXPECT_EQ(AbsolutePath(root / "dangling" / ".." / "b"), root / "b");
}

TEST(WorkspaceTest, DisplayPathIsRelativeInsideOnly) {
  EXPECT_EQ(DisplayPath("/w", "/w/sfm/sparse"), "sfm/sparse");
  EXPECT_EQ(DisplayPath("/w", "sfm/sparse"), "sfm/sparse");
  EXPECT_EQ(DisplayPath("/w", "/w/../photos"), "/photos");
  EXPECT_EQ(DisplayPath("/w", "/world/x"), "/world/x");
}

TEST(WorkspaceTest, InfoRoundTripAndMove) {
  const TemporaryFolder folder;
  fs::create_directory(folder / "w");
  EXPECT_TRUE(ReadWorkspaceInfo(folder / "w")->images.empty());
  WorkspaceInfo info{folder / "w" / "photos", {{"general.seed", "3"}}};
  ASSERT_TRUE(WriteWorkspaceInfo(folder / "w", info).ok());
  fs::rename(folder / "w", folder / "moved");
  const StatusOr<WorkspaceInfo> moved = ReadWorkspaceInfo(folder / "moved");
  ASSERT_TRUE(moved.ok());
  EXPECT_EQ(moved->images, folder / "moved" / "photos");
  EXPECT_EQ(moved->settings.at("general.seed"), "3");

  info.images = "/elsewhere/photos";
  ASSERT_TRUE(WriteWorkspaceInfo(folder / "moved", info).ok());
  EXPECT_EQ(ReadWorkspaceInfo(folder / "moved")->images, "/elsewhere/photos");
}

// JSON holds UTF-8 only.
TEST(WorkspaceTest, InfoKeepsNamesOfAnyBytes) {
  const TemporaryFolder folder;
  for (const char* name :
       {"/ph\xffotos", "/100%", "/100%41\xe9%", "/\xc3\xa9"}) {
    const WorkspaceInfo info{name, {{"sfm.import", name}}};
    ASSERT_TRUE(WriteWorkspaceInfo(folder.path(), info).ok());
    const StatusOr<WorkspaceInfo> read = ReadWorkspaceInfo(folder.path());
    ASSERT_TRUE(read.ok()) << read.status().message();
    EXPECT_EQ(read->images, name);
    EXPECT_EQ(read->settings, info.settings);
  }
}

TEST(WorkspaceTest, MalformedInfoIsBadInput) {
  const TemporaryFolder folder;
  for (const char* text : {"",
                           "3",
                           "{\"images\": 3}",
                           "{\"images\": {}}",
                           "{\"images\": {\"percent\": 3}}",
                           "{\"images\": {\"percent\": \"a%\"}}",
                           "{\"images\": {\"percent\": \"a%f\"}}",
                           "{\"images\": {\"percent\": \"a%fg\"}}",
                           "{\"images\": {\"percent\": \"a%-1\"}}",
                           "{\"settings\": []}",
                           "{\"settings\": {\"a\": 1}}"}) {
    WriteText(folder / "workspace.json", text);
    const Status status = ReadWorkspaceInfo(folder.path()).status();
    EXPECT_EQ(status.code(), StatusCode::kBadInput) << text;
    EXPECT_THAT(status.message(), HasSubstr("; delete the file and give"))
        << text;
  }
}

TEST(WorkspaceTest, OneRunAtATime) {
  const TemporaryFolder folder;
  EXPECT_FALSE(IsLocked(folder.path()));
  {
    const StatusOr<WorkspaceLock> lock = WorkspaceLock::Acquire(folder.path());
    ASSERT_TRUE(lock.ok());
    EXPECT_TRUE(IsLocked(folder.path()));
    const StatusOr<WorkspaceLock> second =
        WorkspaceLock::Acquire(folder.path());
    EXPECT_EQ(second.status().code(), StatusCode::kBadInput);
    EXPECT_THAT(second.status().message(), HasSubstr("another"));
  }
  EXPECT_FALSE(IsLocked(folder.path()));
  EXPECT_TRUE(WorkspaceLock::Acquire(folder.path()).ok());
  EXPECT_FALSE(WorkspaceLock::Acquire(folder / "none").ok());
}

TEST(ExitCodeTest, EveryStatusHasItsExitCode) {
  EXPECT_EQ(ExitCode(StatusCode::kOk), 0);
  EXPECT_EQ(ExitCode(StatusCode::kInternal), 1);
  EXPECT_EQ(ExitCode(StatusCode::kInvalidArgument), 2);
  EXPECT_EQ(ExitCode(StatusCode::kBadInput), 3);
  EXPECT_EQ(ExitCode(StatusCode::kUnusableResult), 4);
  EXPECT_EQ(ExitCode(StatusCode::kMissingDependency), 5);
  EXPECT_EQ(ExitCode(StatusCode::kInterrupted), 130);
}

TEST(InterruptGuardTest, FirstSignalCancels) {
  for (const int signal : {SIGINT, SIGTERM}) {
    CancellationToken token;
    const InterruptGuard guard(&token, /*checkpoint=*/true);
    EXPECT_FALSE(token.cancelled());
    std::raise(signal);
    EXPECT_TRUE(token.cancelled());
  }
}

TEST(ResourceUsageTest, TimesAddUpAndTheLargerPeakStays) {
  const ResourceUsage sum = Sum({1, 2, 5'000'000}, {11, 18, 3'000'000});
  EXPECT_EQ(ToText(sum), "12 s (20 s CPU, peak 5.0 MB)");
}

TEST(ResourceMeterTest, CountsWorkAndMemory) {
  const ResourceMeter meter(PeakMemory::kReset);
  std::vector<char> block(size_t{64} << 20);
  for (size_t i = 0; i < block.size(); i += 4096) block[i] = 1;
  volatile double sum = 0;
  while (meter.Elapsed().cpu_seconds < 0.02) sum = sum + 1;
  const ResourceUsage usage = meter.Elapsed();
  EXPECT_GT(usage.wall_seconds, 0);
  EXPECT_GE(usage.peak_memory_bytes, int64_t{64} << 20);
}

// A stage measures itself while the runner does, and makes meters of its own.
TEST(ResourceMeterTest, ALaterMeterLeavesThePeakOfAnEarlierOne) {
  const ResourceMeter outer(PeakMemory::kReset);
  {
    std::vector<char> block(size_t{64} << 20);
    volatile char* const bytes = block.data();
    for (size_t i = 0; i < block.size(); i += 4096) bytes[i] = 1;
  }
  const int64_t before = outer.Elapsed().peak_memory_bytes;
  const ResourceMeter inner;
  constexpr int64_t kMiB = 1 << 20;  // The kernel does not count exactly.
  EXPECT_GE(outer.Elapsed().peak_memory_bytes, before - kMiB);
  EXPECT_GT(inner.Elapsed().peak_memory_bytes, 0);
}

TEST(SystemInfoTest, CoresMemoryAndDiskArePlausible) {
  EXPECT_GE(AvailableCores(), 1);
  EXPECT_LE(AvailableCores(), CoresOfAffinity());
  const MemoryInfo memory = Memory();
  EXPECT_GT(memory.total_bytes, 0);
  EXPECT_LE(memory.available_bytes, memory.total_bytes);
  EXPECT_GT(FreeDiskBytes(fs::temp_directory_path()).value_or(0), 0);
  EXPECT_FALSE(FreeDiskBytes("/no/such/folder").has_value());
}

}  // namespace
}  // namespace freegs::pipeline
