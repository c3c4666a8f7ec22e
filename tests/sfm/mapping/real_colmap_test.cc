// SPDX-License-Identifier: BSD-3-Clause
// Structure from motion with the installed COLMAP.

#include <filesystem>

#include <gtest/gtest.h>

#include "sfm/colmap/colmap_program.h"
#include "sfm/mapping/health.h"
#include "sfm/mapping/structure_from_motion.h"
#include "sfm/matching/match_database.h"
#include "sfm/scene/model_io_binary.h"
#include "tests/shared_data.h"
#include "tests/temporary_folder.h"

namespace freegs::sfm {
namespace {

namespace fs = std::filesystem;

// The real program on a few real photos, twice: with one and two threads.
TEST(RealColmap, RegistersAndRepeats) {
  const fs::path scene = SharedData("tabletop");
  if (scene.empty()) GTEST_SKIP() << "FREEGS_SHARED_DATA has no tabletop";
  if (!ColmapProgram::Find("colmap", nullptr).ok()) {
    GTEST_SKIP() << "colmap is not installed";
  }
  const TemporaryFolder folder;
  SfmInput input;
  input.photo_folder = scene / "images";
  for (int i = 1; i <= 8; ++i) {
    char name[32];
    std::snprintf(name, sizeof(name), "frame_%04d.jpg", i);
    SfmPhoto photo;
    photo.name = name;
    photo.width = 640;
    photo.height = 480;
    input.photos.push_back(photo);
  }
  SfmOptions options;
  options.max_features = 800;
  options.pairs.matcher = "retrieval";
  options.pairs.num_neighbours = 4;
  std::vector<std::string> results;
  for (const int threads : {1, 2}) {
    options.num_threads = threads;
    input.work_folder = folder / ("work" + std::to_string(threads));
    const auto result = RunStructureFromMotion(input, options);
    ASSERT_TRUE(result.ok()) << result.status().message();
    ASSERT_FALSE(result->models.empty());
    const Reconstruction& model = result->models[0];
    EXPECT_EQ(result->pairs.strategy, "retrieval");
    EXPECT_GE(model.images.size(), 6u);
    // Pairs that hardly match are known as compared, too.
    const auto database =
        MatchDatabase::Open(input.work_folder / "database.db");
    ASSERT_TRUE(database.ok()) << database.status().message();
    const auto compared = database->ComparedPairs();
    ASSERT_TRUE(compared.ok()) << compared.status().message();
    EXPECT_EQ(compared->size(), result->pairs.pairs);
    std::vector<std::string> names;
    for (const SfmPhoto& photo : input.photos) names.push_back(photo.name);
    const Health health = MeasureHealth(result->models, names, true, {});
    EXPECT_LT(health.measures.mean_reprojection_error_px, 1);
    results.push_back(CamerasToBinary(model.cameras) +
                      ImagesToBinary(model.images) +
                      PointsToBinary(model.points3d));
  }
  EXPECT_TRUE(results[0] == results[1]);
}

}  // namespace
}  // namespace freegs::sfm
