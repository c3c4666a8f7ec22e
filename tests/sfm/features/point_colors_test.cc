// SPDX-License-Identifier: BSD-3-Clause

#include "sfm/features/point_colors.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/io/image_io.h"
#include "sfm/colmap/colmap_program.h"
#include "tests/sfm/fake_colmap.h"
#include "tests/temporary_folder.h"

namespace freegs::sfm {
namespace {

using testing::ElementsAre;

constexpr int kColored = 17;

// Photos that are 100, 101, ... red at the left and 200 blue at the right.
class ColorPointsTest : public testing::Test {
 protected:
  ColorPointsTest() {
    input_.photo_folder = folder_.path();
    for (int i = 0; i < kColored; ++i) {
      ImageU8 photo(20, 10, 3, 0);
      for (int y = 0; y < 10; ++y) {
        for (int x = 0; x < 20; ++x) {
          if (x < 10) photo(x, y, 0) = static_cast<uint8_t>(100 + i);
          if (x >= 10) photo(x, y, 2) = 200;
        }
      }
      PosedImage image;
      image.id = i + 1;
      image.camera_id = 1;
      image.name = "photo" + std::to_string(i) + ".png";
      EXPECT_TRUE(WriteImage(folder_ / image.name, photo).ok());
      image.points2d = {{{9.9, 5}, 7}, {{10, 5}, 9}, {{3, 3}, kNoPoint3D}};
      if (i == 0) image.points2d.push_back({{20, 5}, 8});  // Just outside.
      model_.images.push_back(image);
    }
    for (const uint64_t id : {7, 8, 9}) {
      Point3D point;
      point.id = id;
      point.rgb = {1, 2, 3};
      model_.points3d.push_back(point);
    }
  }

  Status Color(int num_threads) {
    auto colmap = ColmapProgram::Find(MakeFakeColmap(folder_.path()), nullptr);
    EXPECT_TRUE(colmap.ok());
    return ColorPoints(input_, num_threads, &model_);
  }

  TemporaryFolder folder_;
  SfmInput input_;
  SfmOptions options_;
  Reconstruction model_;
};

TEST_F(ColorPointsTest, MeanOfWhatObservesThem) {
  for (const int num_threads : {1, 3}) {
    ASSERT_TRUE(Color(num_threads).ok());
    EXPECT_THAT(model_.points3d[0].rgb, ElementsAre(108, 0, 0));
    EXPECT_THAT(model_.points3d[2].rgb, ElementsAre(0, 0, 200));
  }
}

TEST_F(ColorPointsTest, NoObservationNoChange) {
  ASSERT_TRUE(Color(1).ok());
  EXPECT_THAT(model_.points3d[1].rgb, ElementsAre(1, 2, 3));
}

TEST_F(ColorPointsTest, PhotoThatCannotBeRead) {
  model_.images[3].name = "none.png";
  const Status status = Color(2);
  EXPECT_EQ(status.code(), StatusCode::kBadInput);
  EXPECT_THAT(status.message(), testing::HasSubstr("none.png"));
}

}  // namespace
}  // namespace freegs::sfm
