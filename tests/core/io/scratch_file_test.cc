// SPDX-License-Identifier: BSD-3-Clause

#include "core/io/scratch_file.h"

#include <csignal>
#include <cstring>
#include <filesystem>
#include <string>
#include <string_view>
#include <sys/resource.h>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/temporary_folder.h"

namespace freegs {
namespace {

using Bytes = std::span<const std::byte>;

Bytes BytesOf(std::string_view text) {
  return std::as_bytes(std::span(text.data(), text.size()));
}

std::string TextOf(const ScratchFile& file) {
  return {reinterpret_cast<const char*>(file.data()), file.size()};
}

TEST(ScratchFile, HoldsThePartsAndLeavesNoName) {
  const TemporaryFolder folder;
  const std::string large(3 << 20, 'x');
  const std::vector<Bytes> parts = {
      BytesOf("one "), BytesOf(""), BytesOf(large), BytesOf(" two")};
  StatusOr<ScratchFile> file = ScratchFile::Write(folder.path(), parts);
  ASSERT_TRUE(file.ok()) << file.status().message();
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
  EXPECT_EQ(TextOf(*file), "one " + large + " two");

  ScratchFile moved = *std::move(file);
  EXPECT_EQ(moved.size(), large.size() + 8);
  ScratchFile assigned;
  assigned = std::move(moved);
  EXPECT_EQ(TextOf(assigned).substr(0, 4), "one ");
}

TEST(ScratchFile, MayBeEmpty) {
  const TemporaryFolder folder;
  const StatusOr<ScratchFile> file = ScratchFile::Write(folder.path(), {});
  ASSERT_TRUE(file.ok()) << file.status().message();
  EXPECT_EQ(file.value().size(), 0u);
}

TEST(ScratchFile, NamesTheFolderThatCannotBeWritten) {
  const TemporaryFolder folder;
  WriteText(folder / "file", "not a folder");
  for (const char* name : {"missing", "file"}) {
    const StatusOr<ScratchFile> file = ScratchFile::Write(folder / name, {});
    ASSERT_FALSE(file.ok());
    EXPECT_EQ(file.status().code(), StatusCode::kInternal);
    EXPECT_NE(file.status().message().find(name), std::string::npos);
  }
}

TEST(ScratchFile, AFullDiskIsAnErrorThatLeavesNothing) {
  const TemporaryFolder folder;
  const std::string large(1 << 20, 'x');
  const std::vector<Bytes> parts = {BytesOf(large)};
  // A limit on the size of files stands in for the full disk.
  rlimit old_limit;
  ASSERT_EQ(0, getrlimit(RLIMIT_FSIZE, &old_limit));
  const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit limit = {1 << 16, old_limit.rlim_max};
  ASSERT_EQ(0, setrlimit(RLIMIT_FSIZE, &limit));
  const StatusOr<ScratchFile> file = ScratchFile::Write(folder.path(), parts);
  ASSERT_EQ(0, setrlimit(RLIMIT_FSIZE, &old_limit));
  std::signal(SIGXFSZ, old_handler);
  ASSERT_FALSE(file.ok());
  EXPECT_NE(file.status().message().find("cannot write"), std::string::npos);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

}  // namespace
}  // namespace freegs
