// SPDX-License-Identifier: BSD-3-Clause

#include "tests/scene_maker/clutter.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <set>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/io/files.h"
#include "core/io/image_io.h"
#include "tests/scene_maker/scene_files.h"
#include "tests/temporary_folder.h"

namespace freegs::scene_maker {
namespace {

namespace fs = std::filesystem;

SceneMakerOptions Clutter(uint64_t seed) {
  SceneMakerOptions options;
  options.subject = Subject::kClutter;
  options.views = 6;
  options.test_views = 1;
  options.width = 80;
  options.height = 60;
  options.seed = seed;
  return options;
}

TEST(Clutter, EverySeedGivesAScene) {
  std::set<size_t> counts;
  std::set<double> scales;
  for (uint64_t seed = 1; seed <= 40; ++seed) {
    const auto scene = BuildScene(Clutter(seed));
    ASSERT_TRUE(scene.ok()) << seed << ": " << scene.status().message();
    ASSERT_FALSE(scene->objects.empty()) << seed;
    counts.insert(scene->objects.size());
    scales.insert(ClutterScale(seed));
    for (size_t i = 0; i < scene->objects.size(); ++i) {
      EXPECT_EQ(scene->objects[i].id, static_cast<int>(i) + 1);
      EXPECT_TRUE(scene->objects[i].aabb.min.allFinite());
      EXPECT_TRUE(scene->objects[i].aabb.max.allFinite());
    }
  }
  EXPECT_GT(counts.size(), 2u);
  EXPECT_GT(scales.size(), 2u);
  EXPECT_GE(*scales.begin(), 1);
  EXPECT_LE(*scales.rbegin(), 2.4);
}

TEST(Clutter, TheSameSeedGivesTheSameScene) {
  const Scene a = *BuildScene(Clutter(7));
  const Scene b = *BuildScene(Clutter(7));
  ASSERT_EQ(a.objects.size(), b.objects.size());
  for (size_t i = 0; i < a.objects.size(); ++i) {
    EXPECT_EQ(a.objects[i].aabb.min, b.objects[i].aabb.min);
    EXPECT_EQ(a.objects[i].label, b.objects[i].label);
  }
  EXPECT_EQ(a.solids.size(), b.solids.size());
}

TEST(Clutter, AnArcIsCoveredByAnyNumberOfViews) {
  for (const double arc : {25.0, 90.0}) {
    SceneMakerOptions options = Clutter(3);
    options.views = 12;
    options.arc = arc;
    const Scene scene = *BuildScene(options);
    const auto angle = [](const View& view) {
      const Eigen::Vector3d centre = CameraCentre(view.cam_from_world);
      return std::atan2(centre.y(), centre.x()) * 180 / std::numbers::pi;
    };
    double widest = 0;
    for (const View& a : scene.train) {
      for (const View& b : scene.train) {
        widest = std::max(widest,
                          std::abs(std::remainder(angle(a) - angle(b), 360)));
      }
    }
    // The camera shakes a little.
    EXPECT_NEAR(widest, arc, 0.25 * arc);
  }
}

TEST(Clutter, FilesHaveSurfacesAndCamerasThatStageSfmReads) {
  const Scene scene = *BuildScene(Clutter(2));
  const TemporaryFolder temporary;
  const fs::path folder = temporary / "scene";
  ThreadPool pool(2);
  ASSERT_TRUE(WriteScene(scene, folder, pool).ok());

  // Objects as in the instance image, and surfaces of the room around them.
  const ImageU16 ids = *ReadLabels(folder / "gt/instance/test_01.png");
  const ImageU16 all = *ReadLabels(folder / "gt/surfaces/test_01.png");
  std::set<int> surfaces;
  for (size_t i = 0; i < ids.size(); ++i) {
    if (ids.data()[i] > 0) {
      EXPECT_EQ(all.data()[i], ids.data()[i]);
    } else {
      surfaces.insert(all.data()[i]);
    }
  }
  EXPECT_GE(surfaces.size(), 2u);
  EXPECT_GE(*surfaces.begin(), 200);

  // Camera to world, y up and z backwards, as instant-ngp has it.
  const auto file =
      nlohmann::json::parse(*ReadFile(folder / "gt/transforms.json"));
  EXPECT_EQ(file["w"], 80);
  ASSERT_EQ(file["frames"].size(), scene.train.size());
  for (size_t v = 0; v < scene.train.size(); ++v) {
    const auto& frame = file["frames"][v];
    EXPECT_TRUE(fs::exists(folder / std::string(frame["file_path"])));
    const View& view = scene.train[v];
    const Eigen::Vector3d centre = CameraCentre(view.cam_from_world);
    const Eigen::Vector3d backwards =
        -(view.cam_from_world.rotation.inverse() * Eigen::Vector3d::UnitZ());
    for (int k = 0; k < 3; ++k) {
      EXPECT_NEAR(frame["transform_matrix"][k][3], centre[k], 1e-6);
      EXPECT_NEAR(frame["transform_matrix"][k][2], backwards[k], 1e-6);
    }
  }
}

}  // namespace
}  // namespace freegs::scene_maker
