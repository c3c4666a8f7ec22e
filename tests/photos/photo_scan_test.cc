// SPDX-License-Identifier: BSD-3-Clause

#include "photos/photo_scan.h"

#include <algorithm>
#include <string>
#include <sys/stat.h>
#include <unistd.h>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/photos/photo_test_files.h"
#include "tests/unprivileged.h"

namespace freegs::photos {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

TEST(ScanPhotosTest, FindsPhotosBelowInNaturalOrder) {
  const TemporaryFolder folder;
  for (const char* name : {"img10.jpg",
                           "img2.JPG",
                           "deep/er/x.tiff",
                           "deep/y.png",
                           "notes.txt",
                           "photo",
                           ".hidden.jpg",
                           ".thumbs/z.jpg",
                           "z.heic",
                           "z.hif",
                           "z.mpo",
                           "it's \"quoted\".jpg",
                           "größe 日本.png"}) {
    folder.Write(name, "x");
  }
  const auto scan = ScanPhotos(folder.path());
  ASSERT_TRUE(scan.ok());
  EXPECT_THAT(scan->files,
              ElementsAre("deep/er/x.tiff",
                          "deep/y.png",
                          "größe 日本.png",
                          "img2.JPG",
                          "img10.jpg",
                          "it's \"quoted\".jpg",
                          "z.heic",
                          "z.hif",
                          "z.mpo"));
  EXPECT_THAT(scan->warnings, IsEmpty());
}

TEST(ScanPhotosTest, LinkLoopsEndAndFoldersKeepTheirOwnNames) {
  const TemporaryFolder folder;
  folder.Write("real/a.jpg", "x");
  const fs::path root = folder.path();
  fs::create_directory_symlink(root, root / "real" / "loop");
  fs::create_directory_symlink("../real", root / "real" / "self");
  fs::create_directory_symlink(root / "real", root / "also");
  fs::create_symlink("nowhere", root / "broken.jpg");
  fs::create_symlink("circle.jpg", root / "circle.jpg");
  const TemporaryFolder elsewhere;
  elsewhere.Write("b.jpg", "x");
  fs::create_directory_symlink(elsewhere.path(), root / "linked");
  const auto scan = ScanPhotos(root);
  ASSERT_TRUE(scan.ok());
  EXPECT_THAT(
      scan->files,
      ElementsAre("broken.jpg", "circle.jpg", "linked/b.jpg", "real/a.jpg"));
  EXPECT_THAT(scan->linked_folders, ElementsAre("linked"));
}

TEST(ScanPhotosTest, ExcludedFoldersAreNotEntered) {
  const TemporaryFolder folder;
  folder.Write("a.jpg", "x");
  folder.Write("workspace/ingest/photos/a.jpg", "x");
  const auto scan = ScanPhotos(folder.path(), {folder.path() / "workspace"});
  ASSERT_TRUE(scan.ok());
  EXPECT_THAT(scan->files, ElementsAre("a.jpg"));
}

TEST(ScanPhotosTest, BadFolders) {
  const TemporaryFolder folder;
  folder.Write("file.jpg", "x");
  for (const char* name : {"missing", "file.jpg"}) {
    const auto scan = ScanPhotos(folder.path() / name);
    ASSERT_FALSE(scan.ok());
    EXPECT_EQ(scan.status().code(), StatusCode::kBadInput);
    EXPECT_THAT(scan.status().message(), HasSubstr(name));
  }
  const auto none = ScanPhotos("");
  EXPECT_FALSE(none.ok());
}

TEST(ScanPhotosTest, ForbiddenFoldersAreReported) {
  const TemporaryFolder folder;
  folder.Write("a.jpg", "x");
  folder.Write("secret/b.jpg", "x");
  fs::permissions(folder.path() / "secret", fs::perms::none);
  StatusOr<PhotoScan> scan = PhotoScan();
  {
    const Unprivileged user({folder.path(), folder.path() / "secret"});
    if (!user.works()) GTEST_SKIP() << "no other user may look in here";
    scan = ScanPhotos(folder.path());
  }
  fs::permissions(folder.path() / "secret", fs::perms::owner_all);
  ASSERT_TRUE(scan.ok());
  EXPECT_THAT(scan->files, ElementsAre("a.jpg"));
  ASSERT_EQ(scan->warnings.size(), 1U);
  EXPECT_THAT(scan->warnings[0], HasSubstr("secret"));
}

}  // namespace
}  // namespace freegs::photos
