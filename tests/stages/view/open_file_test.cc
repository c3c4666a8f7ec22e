// SPDX-License-Identifier: BSD-3-Clause

#include "stages/view/open_file.h"

#include <filesystem>
#include <string>
#include <sys/stat.h>

#include <gtest/gtest.h>

#include "tests/temporary_folder.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;

class OpenBelowTest : public testing::Test {
 protected:
  OpenBelowTest() {
    folder_.Write("root/a.txt", "inside");
    folder_.Write("root/sub/b.txt", "below");
    folder_.Write("secret.txt", "outside");
    folder_.Write("rooted/c.txt", "a name that begins alike");
  }

  bool Opens(const std::string& name) const {
    return OpenBelow(folder_ / "root", name).ok();
  }

  TemporaryFolder folder_;
};

TEST_F(OpenBelowTest, ReadsFilesOfTheFolder) {
  const auto file = OpenBelow(folder_ / "root", "sub/b.txt");
  ASSERT_TRUE(file.ok()) << file.status().message();
  EXPECT_EQ((*file)->size(), 5u);
  char bytes[8] = {};
  EXPECT_EQ((*file)->Read(1, bytes, sizeof(bytes)), 4u);
  EXPECT_EQ(std::string(bytes), "elow");
  EXPECT_EQ((*file)->Read(99, bytes, sizeof(bytes)), 0u);
  // The folder itself may be a link.
  fs::create_directory_symlink(folder_ / "root", folder_ / "link");
  EXPECT_TRUE(OpenBelow(folder_ / "link", "a.txt").ok());
  fs::create_symlink("sub/b.txt", folder_ / "root/inner.txt");
  EXPECT_TRUE(Opens("inner.txt"));
}

TEST_F(OpenBelowTest, NothingLeavesTheFolder) {
  fs::create_symlink(folder_ / "secret.txt", folder_ / "root/out.txt");
  fs::create_symlink("../../secret.txt", folder_ / "root/sub/out.txt");
  fs::create_directory_symlink(folder_.path(), folder_ / "root/up");
  fs::create_directory_symlink(folder_ / "rooted", folder_ / "root/alike");
  ASSERT_EQ(mkfifo((folder_ / "root/pipe").c_str(), 0600), 0);
  for (const std::string& name : {std::string("out.txt"),
                                  std::string("sub/out.txt"),
                                  std::string("up/secret.txt"),
                                  std::string("alike/c.txt"),
                                  std::string("../secret.txt"),
                                  std::string("sub/../../secret.txt"),
                                  (folder_ / "secret.txt").string(),
                                  std::string("sub"),
                                  std::string("."),
                                  std::string(),
                                  std::string("missing.txt"),
                                  std::string("pipe"),
                                  std::string("a.txt\0b", 7)}) {
    EXPECT_FALSE(Opens(name)) << name;
  }
  EXPECT_FALSE(OpenBelow(folder_ / "missing", "a.txt").ok());
  EXPECT_FALSE(OpenBelow("", "a.txt").ok());
}

TEST(ContentType, GoesByTheExtension) {
  EXPECT_EQ(ContentType("report/index.html"), "text/html; charset=utf-8");
  EXPECT_EQ(ContentType("viewer.js"), "text/javascript; charset=utf-8");
  EXPECT_EQ(ContentType("a.b/photo.JPG"), "image/jpeg");
  EXPECT_EQ(ContentType("x.wasm"), "application/wasm");
  EXPECT_EQ(ContentType("scene.ply"), "application/octet-stream");
  EXPECT_EQ(ContentType("html"), "application/octet-stream");
}

}  // namespace
}  // namespace freegs::stages
