// SPDX-License-Identifier: BSD-3-Clause
// Few photos of many: how many, of which cameras, and what they still see.

#include "sfm/calibration/photo_sample.h"

#include <map>
#include <set>

#include <gtest/gtest.h>

#include "sfm/scene/model_io_binary.h"
#include "tests/sfm/noisy_scene.h"

namespace freegs::sfm {
namespace {

std::string Bytes(const Reconstruction& model) {
  return CamerasToBinary(model.cameras) + ImagesToBinary(model.images) +
         PointsToBinary(model.points3d);
}

Reconstruction Scene(int images, int cameras) {
  NoisyScene scene;
  scene.num_images = images;
  const Camera camera =
      MakeCamera(CameraModel::kSimplePinhole, {500, 320, 240});
  scene.cameras.assign(cameras, camera);
  Reconstruction model = MakeNoisyScene(scene);
  RemoveDanglingReferences(&model);
  return model;
}

TEST(SamplePhotos, FewPhotosStayAsTheyAre) {
  const Reconstruction model = Scene(12, 1);
  EXPECT_TRUE(Bytes(SamplePhotos(model, 12)) == Bytes(model));
}

TEST(SamplePhotos, PhotosOverlapAndReferencesAgree) {
  const Reconstruction model = Scene(60, 1);
  Reconstruction sample = SamplePhotos(model, 20);
  EXPECT_EQ(sample.images.size(), 20u);
  EXPECT_TRUE(CheckReconstruction(sample).ok());
  EXPECT_EQ(RemoveDanglingReferences(&sample), 0u);
  std::set<uint32_t> known;
  uint32_t last = 0;
  for (const PosedImage& image : sample.images) {
    EXPECT_GT(image.id, last);  // In the order that they had.
    last = image.id;
    known.insert(image.id);
  }
  std::map<uint32_t, int> seen;
  for (const Point3D& point : sample.points3d) {
    EXPECT_GE(point.track.size(), 2u);
    for (const TrackElement& element : point.track) {
      EXPECT_TRUE(known.contains(element.image_id));
      ++seen[element.image_id];
    }
  }
  for (const uint32_t id : known) EXPECT_GT(seen[id], 100) << id;
  EXPECT_TRUE(Bytes(SamplePhotos(model, 20)) == Bytes(sample));
}

TEST(SamplePhotos, EveryCameraGetsThree) {
  Reconstruction model = Scene(60, 1);
  // The second camera took the last five photos only.
  model.cameras.push_back(model.cameras[0]);
  model.cameras.back().id = 2;
  for (int i = 55; i < 60; ++i) model.images[i].camera_id = 2;
  const Reconstruction sample = SamplePhotos(model, 9);
  int of_second = 0;
  for (const PosedImage& image : sample.images) {
    of_second += image.camera_id == 2;
  }
  EXPECT_EQ(sample.images.size(), 9u);
  EXPECT_GE(of_second, 3);
}

TEST(SamplePhotos, MoreCamerasThanPhotosWanted) {
  const Reconstruction sample = SamplePhotos(Scene(60, 60), 10);
  EXPECT_EQ(sample.images.size(), 10u);
}

}  // namespace
}  // namespace freegs::sfm
