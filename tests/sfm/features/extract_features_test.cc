// SPDX-License-Identifier: BSD-3-Clause

#include "sfm/features/extract_features.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sfm/colmap/colmap_program.h"
#include "sfm/matching/match_database.h"
#include "tests/sfm/fake_colmap.h"
#include "tests/sfm/textured_photo.h"

namespace freegs::sfm {
namespace {

namespace fs = std::filesystem;

constexpr int kPhotos = 19;  // More than are written together.

class ExtractFeaturesTest : public testing::Test {
 protected:
  ExtractFeaturesTest() {
    input_.photo_folder = folder_ / "photos";
    input_.work_folder = folder_ / "work";
    fs::create_directories(input_.photo_folder);
    fs::create_directories(input_.work_folder / "logs");
    for (int i = 0; i < kPhotos; ++i) {
      SfmPhoto photo;
      photo.name = "photo" + std::to_string(100 + i) + ".png";
      input_.photos.push_back(photo);
      // One has nothing to see.
      EXPECT_TRUE(WriteImage(input_.photo_folder / photo.name,
                             i == 4 ? ImageU8(160, 120, 3, 90)
                                    : TexturedPhoto(160, 120, i))
                      .ok());
    }
    options_.max_image_size = 1600;
  }

  // A database of the photos without features.
  fs::path NewDatabase(const std::string& name) {
    const fs::path path = input_.work_folder / name;
    auto colmap = ColmapProgram::Find(MakeFakeColmap(folder_.path()), nullptr);
    EXPECT_TRUE(colmap.ok());
    const StepContext context{input_, options_, *colmap, 1};
    const Status status = RegisterPhotos(context, path);
    EXPECT_TRUE(status.ok()) << status.message();
    return path;
  }

  Status Extract(const fs::path& path, int num_threads) {
    auto colmap = ColmapProgram::Find(MakeFakeColmap(folder_.path()), nullptr);
    EXPECT_TRUE(colmap.ok());
    const StepContext context{input_, options_, *colmap, num_threads};
    return ExtractFeatures(context, path);
  }

  TemporaryFolder folder_;
  SfmInput input_;
  SfmOptions options_;
};

std::vector<int64_t> Counts(const fs::path& path) {
  const auto database = MatchDatabase::Open(path);
  EXPECT_TRUE(database.ok());
  std::vector<int64_t> counts;
  const auto photos = database->Photos();
  for (const auto& photo : *photos) counts.push_back(photo.num_features);
  return counts;
}

TEST_F(ExtractFeaturesTest, SameBytesForAnyNumberOfThreads) {
  const fs::path one = NewDatabase("one.db");
  EXPECT_THAT(Counts(one), testing::Each(0));
  double done = -1;  // It begins with 0.
  input_.progress = [&](const Progress& progress) {
    EXPECT_EQ(progress.step, "features");
    EXPECT_GT(progress.done, done);
    done = progress.done;
  };
  ASSERT_TRUE(Extract(one, 1).ok());
  EXPECT_EQ(done, kPhotos);
  input_.progress = nullptr;
  const std::vector<int64_t> counts = Counts(one);
  for (int i = 0; i < kPhotos; ++i) EXPECT_EQ(counts[i] > 20, i != 4) << i;

  const fs::path three = NewDatabase("three.db");
  ASSERT_TRUE(Extract(three, 3).ok());
  EXPECT_TRUE(ReadText(one) == ReadText(three));
}

TEST_F(ExtractFeaturesTest, MasksKeepFeaturesOff) {
  const fs::path all = NewDatabase("all.db");
  ASSERT_TRUE(Extract(all, 2).ok());
  input_.mask_folder = folder_ / "masks";
  fs::create_directories(input_.mask_folder);
  for (int i = 0; i < kPhotos; ++i) {
    // The first photo is ignored as a whole.
    EXPECT_TRUE(WriteImage(input_.MaskOf(input_.photos[i].name),
                           ImageU8(160, 120, 1, i == 0 ? 0 : 255))
                    .ok());
  }
  const fs::path masked = NewDatabase("masked.db");
  ASSERT_TRUE(Extract(masked, 2).ok());
  std::vector<int64_t> expected = Counts(all);
  expected[0] = 0;
  EXPECT_EQ(Counts(masked), expected);

  // Every photo must have a mask.
  fs::remove(input_.MaskOf(input_.photos[2].name));
  const Status status = Extract(NewDatabase("none.db"), 2);
  EXPECT_FALSE(status.ok());
  EXPECT_THAT(status.message(),
              testing::HasSubstr(input_.photos[2].name + ".png"));
}

// A run that was killed goes on with the photos that have no features yet.
TEST_F(ExtractFeaturesTest, PhotosWithFeaturesAreNotReadAgain) {
  const fs::path path = NewDatabase("a.db");
  const fs::path last = input_.photo_folder / input_.photos[kPhotos - 1].name;
  const std::string image = ReadText(last);
  WriteText(last, "pixels");
  const Status status = Extract(path, 2);
  EXPECT_EQ(status.code(), StatusCode::kBadInput);
  EXPECT_THAT(status.message(), testing::HasSubstr(last.string()));
  EXPECT_GT(Counts(path)[0], 20);
  EXPECT_EQ(Counts(path)[kPhotos - 1], 0);

  // Photos that have features are not read again.
  fs::remove(input_.photo_folder / input_.photos[0].name);
  WriteText(last, image);
  ASSERT_TRUE(Extract(path, 2).ok());
  EXPECT_GT(Counts(path)[kPhotos - 1], 20);
}

TEST_F(ExtractFeaturesTest, StopsOnRequest) {
  const fs::path path = NewDatabase("a.db");
  CancellationToken token;
  token.Cancel();
  input_.cancellation = &token;
  EXPECT_EQ(Extract(path, 2).code(), StatusCode::kInterrupted);
  EXPECT_THAT(Counts(path), testing::Each(0));
}

}  // namespace
}  // namespace freegs::sfm
