// SPDX-License-Identifier: BSD-3-Clause
// Fingerprints: equal for equal content, different for any difference, and
// unimpressed by hostile folders.

#include "pipeline/fingerprint.h"

#include <chrono>
#include <filesystem>
#include <string>
#include <sys/stat.h>
#include <thread>
#include <unistd.h>

#include <gtest/gtest.h>

#include "tests/temporary_folder.h"

namespace freegs::pipeline {
namespace {

namespace fs = std::filesystem;

class FingerprintTest : public ::testing::Test {
 protected:
  FingerprintTest() {
    WriteText(root() / "b.jpg", "b");
    WriteText(root() / "a.jpg", "a");
    WriteText(root() / "sub" / "c.jpg", "c");
  }
  fs::path root() const { return folder_ / "root"; }
  fs::path cache_path() const { return folder_ / "cache.json"; }
  InputFingerprint Hash(const fs::path& path) {
    return FingerprintCache(folder_.path(), cache_path()).Hash(path);
  }
  TemporaryFolder folder_;
};

TEST_F(FingerprintTest, DependsOnNamesAndContentOnly) {
  const InputFingerprint before = Hash(root());
  EXPECT_EQ(before.files, 3);
  EXPECT_EQ(before.hash.size(), 32u);
  fs::copy(root(), folder_ / "copy", fs::copy_options::recursive);
  EXPECT_EQ(Hash(folder_ / "copy"), before);

  WriteText(root() / "a.jpg", "A");
  const InputFingerprint content = Hash(root());
  EXPECT_NE(content, before);
  WriteText(root() / "a.jpg", "a");
  EXPECT_EQ(Hash(root()), before);
  fs::rename(root() / "a.jpg", root() / "d.jpg");
  EXPECT_NE(Hash(root()), before);
  fs::rename(root() / "d.jpg", root() / "sub" / "a.jpg");
  EXPECT_NE(Hash(root()), before);
}

TEST_F(FingerprintTest, LeavesOutWhatOtherProgramsPutBesidePhotos) {
  const InputFingerprint before = Hash(root());
  for (const char* name : {".DS_Store",
                           "sub/.hidden/d.jpg",
                           "Thumbs.db",
                           "desktop.ini",
                           "a.xmp",
                           "a.jpg.XMP"}) {
    WriteText(root() / name, "x");
    EXPECT_EQ(Hash(root()), before) << name;
  }
  // Photos may lie in a folder of any name.
  WriteText(root() / "b.xmp" / "d.jpg", "d");
  EXPECT_EQ(Hash(root()).files, 4);
}

TEST_F(FingerprintTest, FilesAndMissingThings) {
  EXPECT_EQ(Hash(root() / "a.jpg").files, 1);
  EXPECT_NE(Hash(root() / "a.jpg").hash, Hash(root() / "b.jpg").hash);
  EXPECT_TRUE(Hash(root() / "nothing").missing());
  EXPECT_TRUE(Hash(root() / "a.jpg" / "nothing").missing());
}

TEST_F(FingerprintTest, HostileFolder) {
  fs::create_directory_symlink(root(), root() / "loop");
  fs::create_directory_symlink("/", root() / "everything");
  fs::create_symlink("nowhere", root() / "dangling");
  fs::create_symlink("self", root() / "self");
  fs::create_symlink("a.jpg", root() / "link.jpg");
  ASSERT_EQ(mkfifo((root() / "pipe").c_str(), 0600), 0);
  WriteText(root() / "name \"with\" 'quotes' \xff\xfe\n.jpg", "x");
  WriteText(root() / "secret.jpg", "x");
  fs::permissions(root() / "secret.jpg", fs::perms::none);
  fs::create_directory(root() / "closed");
  fs::permissions(root() / "closed", fs::perms::none);
  const InputFingerprint first = Hash(root());
  EXPECT_EQ(first.hash.size(), 32u);
  EXPECT_EQ(Hash(root()), first);
  WriteText(root() / "a.jpg", "changed");
  EXPECT_NE(Hash(root()), first);
  fs::permissions(root() / "closed", fs::perms::owner_all);
}

TEST_F(FingerprintTest, UnreadableFileCountsAsUnreadable) {
  if (geteuid() == 0) GTEST_SKIP() << "the superuser reads everything";
  fs::permissions(root() / "a.jpg", fs::perms::none);
  EXPECT_EQ(Hash(root() / "a.jpg").hash, "unreadable");
}

TEST_F(FingerprintTest, CacheRemembersSettledFilesOnly) {
  const fs::path file = root() / "a.jpg";
  FingerprintCache fresh(folder_.path(), cache_path());
  const InputFingerprint hash = fresh.Hash(file);
  ASSERT_TRUE(fresh.Save().ok());
  // Just written: it could be written again within the same clock tick.
  EXPECT_FALSE(fs::exists(cache_path()));

  // A planted entry with the file's present data is believed, which shows that
  // the file is not read again.
  struct stat info = {};
  ASSERT_EQ(stat(file.c_str(), &info), 0);
  const auto ns = [](const timespec& t) {
    return std::to_string(t.tv_sec * int64_t{1000000000} + t.tv_nsec);
  };
  const std::string entry = "[" + std::to_string(info.st_size) + "," +
                            ns(info.st_mtim) + "," + ns(info.st_ctim) + "," +
                            std::to_string(info.st_ino) + ",\"planted\"]";
  WriteText(cache_path(), "{\"root/a.jpg\":" + entry + "}");
  EXPECT_EQ(Hash(file).hash, "planted");
  WriteText(file, "longer");
  EXPECT_NE(Hash(file).hash, "planted");
  EXPECT_NE(Hash(file), hash);
}

TEST_F(FingerprintTest, ACancelledCacheRemembersNoFalseHash) {
  const InputFingerprint hash = Hash(root());
  std::this_thread::sleep_for(std::chrono::milliseconds(2100));
  CancellationToken cancelled;
  cancelled.Cancel();
  FingerprintCache cache(folder_.path(), cache_path(), &cancelled);
  EXPECT_NE(cache.Hash(root()), hash);
  ASSERT_TRUE(cache.Save().ok());
  EXPECT_EQ(Hash(root()), hash);
}

// A camera whose clock is wrong makes such files.
TEST_F(FingerprintTest, CacheRemembersFilesFromTheFuture) {
  const fs::path file = root() / "a.jpg";
  fs::last_write_time(
      file, fs::file_time_type::clock::now() + std::chrono::hours(48));
  std::this_thread::sleep_for(std::chrono::milliseconds(2100));
  FingerprintCache cache(folder_.path(), cache_path());
  cache.Hash(file);
  ASSERT_TRUE(cache.Save().ok());
  EXPECT_TRUE(fs::exists(cache_path()));
}

TEST_F(FingerprintTest, DamagedCacheIsIgnored) {
  const InputFingerprint hash = Hash(root());
  for (const char* text : {"",
                           "[",
                           "[]",
                           "{\"root/a.jpg\": 1}",
                           "{\"root/a.jpg\": [1, 2]}",
                           "{\"root/a.jpg\": [\"1\", 2, 3, 4, \"x\"]}"}) {
    WriteText(cache_path(), text);
    EXPECT_EQ(Hash(root()), hash) << text;
  }
}

}  // namespace
}  // namespace freegs::pipeline
