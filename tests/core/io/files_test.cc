// SPDX-License-Identifier: BSD-3-Clause

#include "core/io/files.h"

#include <filesystem>
#include <string>
#include <sys/stat.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/temporary_folder.h"

namespace freegs {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

TEST(FilesTest, WriteThenRead) {
  const TemporaryFolder folder;
  const fs::path path = folder / "a b.bin";
  const std::string content("\0\xff\n text", 8);
  ASSERT_TRUE(WriteFileAtomic(path, content).ok());
  EXPECT_EQ(*ReadFile(path), content);
  ASSERT_TRUE(WriteFileAtomic(path, "").ok());
  EXPECT_EQ(*ReadFile(path), "");
  // Nothing is left beside it.
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), {}), 1);
}

TEST(FilesTest, NamesBelowAFolder) {
  for (const char* name :
       {"a.jpg", "a/b.jpg", "./a", "...", "..a/b..", "a b"}) {
    EXPECT_TRUE(IsNameBelowFolder(name)) << name;
  }
  for (const char* name : {"",
                           "/",
                           "/a",
                           "//a",
                           "..",
                           "../a",
                           "a/../../b",
                           "a/..",
                           "a/",
                           ".",
                           "a/."}) {
    EXPECT_FALSE(IsNameBelowFolder(name)) << name;
  }
  EXPECT_FALSE(IsNameBelowFolder(std::string_view("a\0b", 3)));
}

TEST(FilesTest, FoldersWithinFolders) {
  const TemporaryFolder folder;
  const fs::path outer = folder / "outer";
  fs::create_directories(outer / "a");
  fs::create_directory_symlink(outer / "a", folder / "link");
  for (const fs::path& inner : {outer,
                                outer / "",
                                outer / "a",
                                outer / "..b",
                                outer / "missing/x",
                                folder / "link",
                                folder / "link/new.txt",
                                folder / "link/../new.txt",
                                folder / "missing/../link/new.txt"}) {
    EXPECT_TRUE(IsWithin(inner, outer)) << inner;
    EXPECT_TRUE(IsWithin(inner, outer / "")) << inner;
  }
  for (const fs::path& inner : {folder.path(),
                                folder / "outer2",
                                folder / "missing",
                                outer / "..",
                                outer / "a/../../x",
                                fs::path("/"),
                                fs::path()}) {
    EXPECT_FALSE(IsWithin(inner, outer)) << inner;
  }
  EXPECT_TRUE(IsWithin(outer / "a", folder / "link"));
  EXPECT_TRUE(IsWithin("x/y", "x"));
  EXPECT_TRUE(IsWithin("x/y", "."));
  EXPECT_TRUE(IsWithin(fs::current_path() / "x/y", "x"));
  EXPECT_FALSE(IsWithin("x", fs::path()));
}

TEST(FilesTest, SuffixesInLowerCase) {
  EXPECT_EQ(LowerSuffix("Folder.X/A.B.PLY"), ".ply");
  EXPECT_EQ(LowerSuffix("a"), "");
  EXPECT_EQ(LowerSuffix(".JPG"), "");
}

TEST(FilesTest, LargeFileInSeveralPieces) {
  const TemporaryFolder folder;
  std::string content(size_t{3} << 20, 'x');
  content[(size_t{2} << 20) + 5] = 'y';
  ASSERT_TRUE(WriteFileAtomic(folder / "f", content).ok());
  EXPECT_EQ(*ReadFile(folder / "f"), content);
  EXPECT_EQ(*HashFile(folder / "f"), HashBytes(content));
  CancellationToken cancelled;
  EXPECT_EQ(*HashFile(folder / "f", &cancelled), HashBytes(content));
  cancelled.Cancel();
  EXPECT_EQ(HashFile(folder / "f", &cancelled).status().code(),
            StatusCode::kInterrupted);
}

TEST(FilesTest, ReadErrorsNameTheFile) {
  const TemporaryFolder folder;
  const auto code = [](const fs::path& path) {
    EXPECT_THAT(ReadFile(path).status().message(),
                HasSubstr(path.filename().string()));
    EXPECT_EQ(HashFile(path).status().code(), ReadFile(path).status().code());
    return ReadFile(path).status().code();
  };
  EXPECT_EQ(code(folder / "missing"), StatusCode::kBadInput);
  fs::create_directory(folder / "folder");
  EXPECT_EQ(code(folder / "folder"), StatusCode::kBadInput);
  fs::create_symlink("loop", folder / "loop");
  EXPECT_EQ(code(folder / "loop"), StatusCode::kBadInput);
  // Opening a pipe nobody writes to would wait for ever.
  ASSERT_EQ(mkfifo((folder / "pipe").c_str(), 0600), 0);
  EXPECT_EQ(code(folder / "pipe"), StatusCode::kBadInput);
}

// As a file in a folder that is closed to the user, which no test that runs as
// the superuser can have.
TEST(FilesTest, WhatIsThereIsNotCalledMissing) {
  const TemporaryFolder folder;
  EXPECT_THAT(ReadFile(folder / "missing").status().message(),
              HasSubstr("cannot read: no such file"));
  fs::create_symlink("loop", folder / "loop");
  EXPECT_THAT(ReadFile(folder / "loop" / "f").status().message(),
              HasSubstr("cannot read: Too many levels of symbolic links"));
}

// Nobody can write to this device.
TEST(FilesTest, TheReasonOfAFailedWriteIsNamed) {
  const TemporaryFolder folder;
  fs::create_symlink("/dev/full", folder / "f.part");
  const Status status = WriteFileAtomic(folder / "f", "x");
  EXPECT_EQ(status.code(), StatusCode::kInternal);
  EXPECT_THAT(status.message(),
              HasSubstr("f.part: cannot write: No space left on device"));
  EXPECT_FALSE(fs::exists(folder / "f.part"));
}

TEST(FilesTest, SizeLimit) {
  const TemporaryFolder folder;
  WriteText(folder / "f", "12345");
  EXPECT_TRUE(ReadFile(folder / "f", 5).ok());
  EXPECT_THAT(ReadFile(folder / "f", 4).status().message(),
              HasSubstr("larger than 4"));
}

TEST(FilesTest, WriteIntoMissingFolderFails) {
  const TemporaryFolder folder;
  EXPECT_FALSE(WriteFileAtomic(folder / "no" / "f", "x").ok());
  ASSERT_TRUE(CreateFolders(folder / "no" / "deeper").ok());
  EXPECT_TRUE(WriteFileAtomic(folder / "no" / "f", "x").ok());
  EXPECT_FALSE(CreateFolders(folder / "no" / "f" / "g").ok());
}

TEST(FilesTest, FailedReplacementLeavesNothing) {
  const TemporaryFolder folder;
  ASSERT_TRUE(CreateFolders(folder / "f" / "deeper").ok());
  EXPECT_FALSE(WriteFileAtomic(folder / "f", "x").ok());
  EXPECT_FALSE(fs::exists(folder / "f.part"));
}

TEST(FilesTest, FlushesWhatIsThere) {
  const TemporaryFolder folder;
  WriteText(folder / "f", "12345");
  EXPECT_TRUE(FlushToDisk(folder / "f").ok());
  EXPECT_TRUE(FlushToDisk(folder.path()).ok());
  EXPECT_TRUE(FlushToDisk(folder / "missing").ok());
}

TEST(FilesTest, HashesTellContentsApart) {
  EXPECT_EQ(HashBytes("").size(), 32u);
  EXPECT_EQ(HashBytes("a"), HashBytes("a"));
  EXPECT_NE(HashBytes("a"), HashBytes("b"));
  // XXH3's published 128-bit value of the empty string.
  EXPECT_EQ(HashBytes(""), "99aa06d3014798d86001c324468d497f");
}

TEST(FilesTest, OutputPathsOfTheUser) {
  const TemporaryFolder folder;
  folder.Write("file", "");
  EXPECT_TRUE(PrepareOutputFolder(folder / "new/folder").ok());
  EXPECT_TRUE(std::filesystem::is_directory(folder / "new/folder"));
  EXPECT_TRUE(PrepareOutputFolder(folder.path()).ok());
  EXPECT_TRUE(PrepareOutputFile(folder / "file").ok());
  EXPECT_TRUE(PrepareOutputFile(folder / "other/file").ok());
  EXPECT_TRUE(PrepareOutputFile("file").ok());
  ASSERT_EQ(mkfifo((folder / "pipe").c_str(), 0600), 0);
  for (const Status& status :
       {PrepareOutputFolder(folder / "file/below"),
        PrepareOutputFolder(folder / "file"),
        PrepareOutputFile(folder / "file/below/a").status(),
        PrepareOutputFile(folder.path()).status(),
        PrepareOutputFile(folder / "new/").status(),
        PrepareOutputFile(folder / "pipe").status(),
        PrepareOutputFile("/dev/null").status(),
        PrepareOutputFolder("/proc/1/freegs")}) {
    EXPECT_EQ(status.code(), StatusCode::kBadInput);
    EXPECT_THAT(status.message(), testing::HasSubstr("; give a"));
  }
}

TEST(FilesTest, OutputGoesThroughLinks) {
  const TemporaryFolder folder;
  folder.Write("kept/a.ply", "old");
  fs::create_symlink("kept/a.ply", folder / "link.ply");
  const auto path = PrepareOutputFile(folder / "link.ply");
  ASSERT_TRUE(path.ok()) << path.status().message();
  ASSERT_TRUE(WriteFileAtomic(*path, "new").ok());
  EXPECT_TRUE(fs::is_symlink(folder / "link.ply"));
  EXPECT_EQ(ReadFile(folder / "kept/a.ply").value(), "new");
  fs::create_symlink("kept/a.ply", folder / "link.spz");
  fs::create_symlink("kept/none.ply", folder / "nowhere.ply");
  fs::create_symlink("loop.ply", folder / "loop.ply");
  for (const char* name : {"link.spz", "nowhere.ply", "loop.ply"}) {
    const Status status = PrepareOutputFile(folder / name).status();
    EXPECT_EQ(status.code(), StatusCode::kBadInput) << name;
    EXPECT_THAT(status.message(), HasSubstr(": is a link")) << name;
  }
}

}  // namespace
}  // namespace freegs
