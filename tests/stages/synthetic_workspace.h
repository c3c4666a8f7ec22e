// SPDX-License-Identifier: BSD-3-Clause
// A small finished workspace, made without running any stage: a random scene,
// its photos (pictures of itself), and optionally instances.

#ifndef FREEGS_TESTS_STAGES_SYNTHETIC_WORKSPACE_H_
#define FREEGS_TESTS_STAGES_SYNTHETIC_WORKSPACE_H_

#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/io/image_io.h"
#include "core/parallel.h"
#include "photos/photo_list.h"
#include "pipeline/stage_record.h"
#include "semantics/field/idsf.h"
#include "semantics/instances/hierarchy.h"
#include "semantics/instances/instances.h"
#include "semantics/instances/instances_json.h"
#include "sfm/scene/model_io.h"
#include "splat/render/renderer.h"
#include "splat/scene/ply_io.h"
#include "tests/splat/test_scene.h"
#include "tests/temporary_folder.h"

namespace freegs::stages {

class SyntheticWorkspace {
 public:
  static constexpr int kWidth = 64;
  static constexpr int kHeight = 48;
  static constexpr int kTrainingSide = 32;

  // `num_photos` photos, every third one held out; the first has a name that is
  // awkward in HTML and URLs.
  explicit SyntheticWorkspace(int num_photos = 6)
      : model(splat::RandomSceneModel(120, 1, 5)) {
    ThreadPool pool(2);
    sfm::Reconstruction sparse;
    sfm::Camera camera;
    camera.id = 1;
    camera.model = sfm::CameraModel::kPinhole;
    camera.width = kWidth;
    camera.height = kHeight;
    const Pinhole pinhole = splat::TestCamera(kWidth, kHeight);
    camera.params = {pinhole.fx, pinhole.fy, pinhole.cx, pinhole.cy};
    sparse.cameras.push_back(camera);
    photos::PhotoList photos;
    for (int k = 0; k < num_photos; ++k) {
      View view;
      view.name =
          k == 0 ? "a <b>&'c#d.png" : "photo" + std::to_string(k) + ".png";
      view.camera = pinhole;
      Rigid3d orbit;
      orbit.rotation =
          Eigen::AngleAxisd(0.1 * k, Eigen::Vector3d(0.2, 1, 0).normalized());
      view.cam_from_world = splat::TestPose() * orbit;
      sfm::PosedImage image;
      image.id = static_cast<uint32_t>(k + 1);
      image.camera_id = 1;
      image.name = view.name;
      image.cam_from_world = view.cam_from_world;
      sparse.images.push_back(image);

      const splat::RenderedView picture = splat::RenderView(
          model, pinhole, view.cam_from_world, splat::RenderOptions(), pool);
      const std::filesystem::path file =
          path() / "undistort" / "images" / view.name;
      std::filesystem::create_directories(file.parent_path());
      EXPECT_TRUE(WriteImage(file, ToU8(picture.color)).ok());

      photos::Photo photo;
      photo.file = photo.name = view.name;
      photo.width = kWidth;
      photo.height = kHeight;
      photo.camera_group = 0;
      photo.split = k % 3 == 0 ? photos::PhotoSplit::kHoldout
                               : photos::PhotoSplit::kTrain;
      photos.photos.push_back(photo);
      views.push_back(view);
    }
    EXPECT_TRUE(sfm::WriteModel(path() / "undistort" / "sparse", sparse).ok());
    std::filesystem::create_directories(path() / "ingest");
    EXPECT_TRUE(
        photos::WritePhotoList(path() / "ingest" / "images.json", photos).ok());
    std::filesystem::create_directories(path() / "reconstruct");
    EXPECT_TRUE(
        splat::WritePly(path() / "reconstruct" / "point_cloud.ply", model)
            .ok());
    pipeline::StageRecord record;
    record.fingerprint.stage = "reconstruct";
    record.fingerprint.options = {
        {"reconstruct.max_image_size", std::to_string(kTrainingSide)},
        {"reconstruct.background", "white"}};
    record.wall_seconds = 75;
    record.cpu_seconds = 140;
    record.peak_memory_bytes = 250'000'000;
    EXPECT_TRUE(
        pipeline::WriteStageRecord(path() / "reconstruct", record).ok());
  }

  // Gaussian i belongs to instance i % 4, where 3 stands for none.
  void AddInstances() {
    ThreadPool pool(1);
    labels.clear();
    for (size_t i = 0; i < model.size(); ++i) {
      labels.push_back(i % 4 == 3 ? -1 : static_cast<int32_t>(i % 4));
    }
    semantics::Idsf idsf;
    idsf.instances = labels;
    std::filesystem::create_directories(path() / "bootstrap");
    EXPECT_TRUE(
        semantics::WriteIdsf(path() / "bootstrap" / "idsf.bin", idsf).ok());
    instances = semantics::BuildInstances(model,
                                          labels,
                                          3,
                                          {},
                                          {},
                                          std::nullopt,
                                          semantics::InstanceBoxOptions(),
                                          pool);
    EXPECT_TRUE(semantics::WriteInstances(
                    path() / "bootstrap" / "instances.json", instances)
                    .ok());
  }

  // Instance k has parts 2 k and 2 k + 1; instances 0 and 1 are a group, then
  // all three.
  void AddHierarchy() const {
    semantics::Hierarchy hierarchy;
    hierarchy.tree = {
        .num_leaves = 6,
        .merges = {{0, 1, -2}, {2, 3, -2}, {4, 5, -2}, {6, 7, 1}, {8, 9, 2}}};
    hierarchy.quality = {
        0.46, 0.46, 0.46, 0.46, 0.46, 0.46, 0.9, 0.9, 0.9, 0.8, 0.5};
    hierarchy.part_pixels = {100, 90, 80, 70, 60, 50};
    hierarchy.total_pixels = 450;
    for (size_t i = 0; i < model.size(); ++i) {
      hierarchy.part_of_gaussian.push_back(
          i % 4 == 3 ? -1 : static_cast<int32_t>(2 * (i % 4) + i / 4 % 2));
    }
    EXPECT_TRUE(semantics::WriteHierarchy(
                    path() / "bootstrap" / "hierarchy.json", hierarchy)
                    .ok());
  }

  const std::filesystem::path& path() const { return folder_.path(); }
  std::filesystem::path operator/(const std::string& name) const {
    return path() / name;
  }

  splat::GaussianModel model;
  std::vector<View> views;  // The views of the photos, at their own size.
  std::vector<int32_t> labels;
  std::vector<semantics::Instance> instances;

 private:
  TemporaryFolder folder_;
};

}  // namespace freegs::stages

#endif  // FREEGS_TESTS_STAGES_SYNTHETIC_WORKSPACE_H_
