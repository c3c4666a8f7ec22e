// SPDX-License-Identifier: BSD-3-Clause

#include "stages/reconstruct/training_preview.h"

#include <filesystem>

#include <gtest/gtest.h>

#include "core/io/image_io.h"
#include "tests/splat/test_scene.h"
#include "tests/temporary_folder.h"

namespace freegs::stages {
namespace {

TEST(TrainingPreview, ComesSeldomAndTheLaterTheLongerItTakes) {
  const TemporaryFolder folder;
  ThreadPool pool(1);
  View view;
  view.camera = splat::TestCamera(80, 60);
  view.cam_from_world = splat::TestPose();
  double now = 100;
  TrainingPreview preview(
      {.file = folder / "a.jpg", .max_side = 40}, view, {}, [&now] {
        return now;
      });
  ASSERT_TRUE(preview.Due());
  preview.Write(splat::GaussianModel(), pool, [&now] { now += 0.01; });
  const StatusOr<ImageU8> picture = ReadRgb(folder / "a.jpg");
  ASSERT_TRUE(picture.ok()) << picture.status().message();
  EXPECT_EQ(picture->width(), 40);
  now = 104.9;
  EXPECT_FALSE(preview.Due());
  now = 105;
  EXPECT_TRUE(preview.Due());
  // A picture that takes 0.1 s may come every 20 s, so that it takes 0.5 % of
  // the time.
  preview.Write(splat::GaussianModel(), pool, [&now] { now += 0.1; });
  now = 124.9;
  EXPECT_FALSE(preview.Due());
  now = 125.1;
  EXPECT_TRUE(preview.Due());
}

TEST(TrainingPreview, IsNeverDueWithoutAFile) {
  const View view = {.name = "",
                     .camera = splat::TestCamera(80, 60),
                     .cam_from_world = splat::TestPose()};
  EXPECT_FALSE(TrainingPreview({}, view, {}).Due());
}

}  // namespace
}  // namespace freegs::stages
