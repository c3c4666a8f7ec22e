// SPDX-License-Identifier: BSD-3-Clause

#include "splat/images/training_images.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/io/files.h"
#include "core/io/image_io.h"
#include "core/random.h"
#include "tests/temporary_folder.h"

namespace freegs::splat {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;

class TrainingImagesTest : public ::testing::Test {
 protected:
  // A photo of random pixels, and its view.
  void AddPhoto(const std::string& name, int width, int height) {
    ImageU8 photo(width, height, 3);
    for (size_t i = 0; i < photo.size(); ++i) {
      photo.data()[i] =
          static_cast<uint8_t>(RandomBits(views_.size(), 0, i) & 255);
    }
    fs::create_directories((folder_ / name).parent_path());
    ASSERT_TRUE(WriteImage(folder_ / name, photo).ok());
    View view;
    view.name = name;
    view.camera = {width, height, 100.0, 110.0, width / 2.0, height / 2.0};
    views_.push_back(view);
    photos_.push_back(photo);
  }

  StatusOr<TrainingImages> Load(const TrainingImagesOptions& options) {
    return TrainingImages::Load(views_, folder_, options, pool_);
  }

  const TemporaryFolder temporary_;
  const fs::path folder_ = temporary_.path();
  std::vector<View> views_;
  std::vector<ImageU8> photos_;
  ThreadPool pool_{2};
};

TEST_F(TrainingImagesTest, LevelZeroIsThePhoto) {
  AddPhoto("a.png", 12, 8);
  AddPhoto("b c.png", 7, 9);
  StatusOr<TrainingImages> images = Load({});
  ASSERT_TRUE(images.ok()) << images.status().message();
  ASSERT_EQ(images->size(), 2u);
  ImageF image;
  for (size_t i = 0; i < 2; ++i) {
    ASSERT_TRUE(images->Fetch(i, 0, &image).ok());
    const ImageF expected = ToFloat(photos_[i]);
    ASSERT_EQ(image.size(), expected.size());
    EXPECT_TRUE(
        std::equal(image.data(), image.data() + image.size(), expected.data()));
    EXPECT_EQ(images->view(i).camera.width, views_[i].camera.width);
    EXPECT_EQ(images->view(i).name, views_[i].name);
  }
}

TEST_F(TrainingImagesTest, LevelsAverageAndCamerasFollow) {
  AddPhoto("a.png", 12, 8);
  AddPhoto("odd.png", 7, 3);
  StatusOr<TrainingImages> images = Load({});
  ASSERT_TRUE(images.ok());
  ImageF image;
  ASSERT_TRUE(images->Fetch(0, 1, &image).ok());
  ASSERT_EQ(image.width(), 6);
  ASSERT_EQ(image.height(), 4);
  const ImageU8& photo = photos_[0];
  for (int c = 0; c < 3; ++c) {
    const double mean =
        (photo(4, 2, c) + photo(5, 2, c) + photo(4, 3, c) + photo(5, 3, c)) /
        (4 * 255.0);
    EXPECT_NEAR(image(2, 1, c), mean, 0.51 / 255);
  }
  const Pinhole camera = images->view(0, 1).camera;
  EXPECT_EQ(camera.width, 6);
  EXPECT_DOUBLE_EQ(camera.fx, 50.0);
  EXPECT_DOUBLE_EQ(camera.fy, 55.0);
  EXPECT_DOUBLE_EQ(camera.cx, 3.0);

  for (int level = 0; level < images->num_levels(); ++level) {
    ASSERT_TRUE(images->Fetch(1, level, &image).ok());
    EXPECT_EQ(image.width(), images->view(1, level).camera.width);
    EXPECT_EQ(image.height(), images->view(1, level).camera.height);
  }
  EXPECT_EQ(image.height(), 1);
}

TEST_F(TrainingImagesTest, LimitsTheLongestSide) {
  AddPhoto("wide.png", 40, 20);
  AddPhoto("tall.png", 30, 60);
  AddPhoto("small.png", 10, 5);
  StatusOr<TrainingImages> images = Load({.max_side = 20});
  ASSERT_TRUE(images.ok());
  EXPECT_EQ(images->view(0).camera.width, 20);
  EXPECT_EQ(images->view(0).camera.height, 10);
  EXPECT_EQ(images->view(1).camera.width, 10);
  EXPECT_EQ(images->view(1, 1).camera.height, 10);
  EXPECT_EQ(images->view(2).camera.width, 10);
  EXPECT_DOUBLE_EQ(images->view(0).camera.fx, 50.0);
}

TEST_F(TrainingImagesTest, MasksFollowTheLevels) {
  AddPhoto("sub/a.png", 12, 8);
  AddPhoto("b.png", 12, 8);
  ImageU8 mask(12, 8, 1, 255);
  mask(5, 3) = 0;
  const TemporaryFolder masks;
  fs::create_directories(masks.path() / "sub");
  ASSERT_TRUE(WriteImage(masks.path() / "sub/a.png.png", mask).ok());
  // With a cap of one photo, so that photo and mask are read again.
  for (const uint64_t cap : {uint64_t{1} << 30, uint64_t{1}}) {
    StatusOr<TrainingImages> images =
        Load({.max_bytes = cap, .mask_folder = masks.path()});
    ASSERT_TRUE(images.ok()) << images.status().message();
    ImageF image;
    for (int level = 0; level < 3; ++level) {
      ASSERT_TRUE(images->Fetch(1, level, &image).ok());
      EXPECT_EQ(images->Mask(1, level), nullptr);
      ASSERT_TRUE(images->Fetch(0, level, &image).ok());
      const ImageU8* const found = images->Mask(0, level);
      ASSERT_NE(found, nullptr);
      ASSERT_EQ(found->width(), image.width());
      ASSERT_EQ(found->height(), image.height());
      for (int y = 0; y < found->height(); ++y) {
        for (int x = 0; x < found->width(); ++x) {
          const bool ignored = x == 5 >> level && y == 3 >> level;
          EXPECT_EQ((*found)(x, y), ignored ? 0 : 255);
        }
      }
    }
  }
}

// 24 x 21 is reduced to 12 x 11, whose half has 6 rows: they do not meet rows
// of the photo at borders. A pixel of the half is used only if all pixels of
// the larger level that it averages are.
TEST_F(TrainingImagesTest, SmallMasksAreThoseOfLargerOnes) {
  AddPhoto("a.png", 24, 21);
  for (int last = 0; last < 20; ++last) {
    ImageU8 mask(24, 21, 1, 255);
    std::fill_n(mask.data(), 24 * (last + 1), uint8_t{0});
    const TemporaryFolder masks;
    ASSERT_TRUE(WriteImage(masks.path() / "a.png.png", mask).ok());
    StatusOr<TrainingImages> images =
        Load({.max_side = 12, .mask_folder = masks.path()});
    ASSERT_TRUE(images.ok()) << images.status().message();
    ImageF image;
    ASSERT_TRUE(images->Fetch(0, 1, &image).ok());
    const ImageU8& large = *images->Mask(0, 0);
    const ImageU8& small = *images->Mask(0, 1);
    const double step = static_cast<double>(large.height()) / small.height();
    for (int y = 0; y < small.height(); ++y) {
      if (small(0, y) == 0) continue;
      EXPECT_NE(large(0, static_cast<int>(y * step + 1e-9)), 0)
          << last << " " << y;
    }
  }
}

TEST_F(TrainingImagesTest, RefusesMasksThatDoNotFit) {
  AddPhoto("a.png", 12, 8);
  const TemporaryFolder masks;
  const auto load = [&] { return Load({.mask_folder = masks.path()}); };
  ASSERT_TRUE(WriteImage(masks.path() / "a.png.png", ImageU8(8, 12, 1)).ok());
  EXPECT_THAT(load().status().message(),
              AllOf(HasSubstr("a.png.png"), HasSubstr("8x12")));
  ASSERT_TRUE(WriteFileAtomic(masks.path() / "a.png.png", "no mask").ok());
  EXPECT_EQ(load().status().code(), StatusCode::kBadInput);
}

TEST_F(TrainingImagesTest, MemoryCapDoesNotChangeWhatIsFetched) {
  for (int i = 0; i < 6; ++i) {
    AddPhoto("photo" + std::to_string(i) + ".png", 16, 16 + i);
  }
  StatusOr<TrainingImages> all = Load({});
  ASSERT_TRUE(all.ok());
  for (const uint64_t cap : {uint64_t{0}, uint64_t{1}, uint64_t{3000}}) {
    StatusOr<TrainingImages> capped = Load({.max_bytes = cap});
    ASSERT_TRUE(capped.ok());
    ImageF expected;
    ImageF image;
    for (uint64_t step = 0; step < 40; ++step) {
      const size_t index = RandomIndex(1, 2, step, 6);
      const int level = static_cast<int>(step % 3);
      ASSERT_TRUE(all->Fetch(index, level, &expected).ok());
      ASSERT_TRUE(capped->Fetch(index, level, &image).ok());
      ASSERT_EQ(image.size(), expected.size());
      ASSERT_TRUE(std::equal(
          image.data(), image.data() + image.size(), expected.data()));
    }
  }
}

// A pyramid of 16 x 16 pixels takes 768 + 192 + 48 bytes. Without their files
// only the photos in memory can be fetched, of which fetching drops none.
TEST_F(TrainingImagesTest, HoldsNoMoreThanTheMemoryCap) {
  for (const auto& [cap, held] : std::map<uint64_t, int>{
           {0, 1}, {1, 1}, {1008, 1}, {2015, 1}, {2016, 2}, {6000, 5}}) {
    for (int i = 0; i < 6; ++i) {
      AddPhoto("photo" + std::to_string(i) + ".png", 16, 16);
    }
    StatusOr<TrainingImages> images = Load({.max_bytes = cap});
    ASSERT_TRUE(images.ok());
    ImageF image;
    for (size_t i = 0; i < 6; ++i) {
      ASSERT_TRUE(images->Fetch(i, 0, &image).ok());
    }
    int found = 0;
    for (size_t i = 0; i < 6; ++i) {
      fs::remove(folder_ / ("photo" + std::to_string(i) + ".png"));
      found += images->Fetch(i, 0, &image).ok();
    }
    EXPECT_EQ(found, held) << cap;
    views_.clear();
  }
}

TEST_F(TrainingImagesTest, KeepsTheRecentlyUsed) {
  for (int i = 0; i < 3; ++i) {
    AddPhoto("photo" + std::to_string(i) + ".png", 16, 16);
  }
  // 16 * 16 * 3 bytes and one level: room for two.
  StatusOr<TrainingImages> images = Load({.num_levels = 1, .max_bytes = 1600});
  ASSERT_TRUE(images.ok());
  ImageF image;
  ASSERT_TRUE(images->Fetch(0, 0, &image).ok());
  ASSERT_TRUE(images->Fetch(2, 0, &image).ok());  // Drops 1.
  fs::remove(folder_ / "photo0.png");
  EXPECT_TRUE(images->Fetch(0, 0, &image).ok());
  fs::remove(folder_ / "photo1.png");
  const Status gone = images->Fetch(1, 0, &image);
  EXPECT_EQ(gone.code(), StatusCode::kBadInput);
  EXPECT_THAT(gone.message(), HasSubstr("photo1.png"));
}

// Room for three of four photos. In each round after the first only one is read
// from its file.
TEST_F(TrainingImagesTest, OfPhotosInOrderMostStayInMemory) {
  for (int i = 0; i < 4; ++i) {
    AddPhoto("photo" + std::to_string(i) + ".png", 16, 16);
  }
  StatusOr<TrainingImages> images =
      Load({.num_levels = 1, .max_bytes = 2400, .fetched_in_order = true});
  ASSERT_TRUE(images.ok());
  ImageF image;
  for (const size_t i : {0, 1, 2, 3}) {
    ASSERT_TRUE(images->Fetch(i, 0, &image).ok());
  }
  for (const size_t i : {0, 1, 3}) fs::remove(folder_ / views_[i].name);
  for (const size_t i : {0, 1, 2, 3, 0}) {
    ASSERT_TRUE(images->Fetch(i, 0, &image).ok()) << i;
    const ImageF expected = ToFloat(photos_[i]);
    EXPECT_TRUE(
        std::equal(image.data(), image.data() + image.size(), expected.data()));
  }
  EXPECT_FALSE(images->Fetch(1, 0, &image).ok());
}

TEST_F(TrainingImagesTest, SubsetsFetchTheSame) {
  for (const char* name : {"a.png", "b.png", "c.png"}) AddPhoto(name, 12, 8);
  for (const uint64_t max_bytes : {uint64_t{400}, uint64_t{1} << 20}) {
    StatusOr<TrainingImages> images = Load({.max_bytes = max_bytes});
    ASSERT_TRUE(images.ok());
    const std::vector<size_t> indices = {2, 0};
    TrainingImages subset = images->Subset(indices);
    ASSERT_EQ(subset.size(), 2u);
    EXPECT_EQ(subset.view(0).name, "c.png");
    ImageF expected;
    ImageF image;
    for (const size_t i : {1, 0, 1}) {
      ASSERT_TRUE(subset.Fetch(i, 1, &image).ok());
      ASSERT_TRUE(images->Fetch(indices[i], 1, &expected).ok());
      EXPECT_TRUE(std::equal(
          image.data(), image.data() + image.size(), expected.data()));
    }
  }
}

// A cap of two photos, for all together.
TEST_F(TrainingImagesTest, SubsetsShareTheMemoryCap) {
  for (int i = 0; i < 6; ++i) {
    AddPhoto("photo" + std::to_string(i) + ".png", 16, 16);
  }
  StatusOr<TrainingImages> images = Load({.max_bytes = 2016});
  ASSERT_TRUE(images.ok());
  TrainingImages even = images->Subset(std::vector<size_t>{0, 2, 4});
  TrainingImages odd = images->Subset(std::vector<size_t>{1, 3, 5});
  ImageF image;
  for (size_t i = 0; i < 3; ++i) {
    ASSERT_TRUE(even.Fetch(i, 0, &image).ok());
    ASSERT_TRUE(odd.Fetch(i, 0, &image).ok());
  }
  for (const View& view : views_) fs::remove(folder_ / view.name);
  int found = 0;
  for (size_t i = 0; i < 3; ++i) {
    found += even.Fetch(i, 0, &image).ok();
    found += odd.Fetch(i, 0, &image).ok();
  }
  EXPECT_EQ(found, 2);
  // A subset of a subset; it outlives both.
  images = TrainingImages(odd.Subset(std::vector<size_t>{2}));
  ASSERT_EQ(images->size(), 1u);
  EXPECT_EQ(images->view(0).name, "photo5.png");
  EXPECT_TRUE(images->Fetch(0, 0, &image).ok());
}

TEST_F(TrainingImagesTest, UnusablePhotosAreNamed) {
  AddPhoto("good.png", 8, 8);
  AddPhoto("other.png", 8, 8);
  views_[1].camera.width = 9;
  EXPECT_THAT(
      Load({}).status().message(),
      AllOf(HasSubstr("other.png"), HasSubstr("8x8"), HasSubstr("9x8")));
  views_[1].camera.width = 8;
  ASSERT_TRUE(WriteFileAtomic(folder_ / "other.png", "no picture").ok());
  EXPECT_THAT(Load({}).status().message(), HasSubstr("other.png"));
  views_[1].name = "missing.png";
  EXPECT_THAT(Load({}).status().message(), HasSubstr("missing.png"));
  EXPECT_EQ(Load({}).status().code(), StatusCode::kBadInput);
}

TEST_F(TrainingImagesTest, ReadingPhotosCanBeStopped) {
  AddPhoto("a.png", 8, 8);
  CancellationToken token;
  EXPECT_TRUE(TrainingImages::Load(views_, folder_, {}, pool_, &token).ok());
  token.Cancel();
  EXPECT_EQ(
      TrainingImages::Load(views_, folder_, {}, pool_, &token).status().code(),
      StatusCode::kInterrupted);
}

TEST_F(TrainingImagesTest, OptionsAreChecked) {
  EXPECT_TRUE(Load({}).ok());  // No views is no error here.
  EXPECT_FALSE(Load({.max_side = -1}).ok());
  EXPECT_FALSE(Load({.num_levels = 0}).ok());
}

}  // namespace
}  // namespace freegs::splat
