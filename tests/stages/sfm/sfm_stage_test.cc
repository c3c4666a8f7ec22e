// SPDX-License-Identifier: BSD-3-Clause
// The sfm stage on a fake COLMAP: verdicts, files, imports.

#include "stages/sfm/sfm_stage.h"

#include <algorithm>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sfm/scene/model_io.h"
#include "tests/sfm/fake_colmap.h"
#include "tests/stages/sfm_workspace.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::SizeIs;

class SfmStageTest : public testing::Test {
 protected:
  using Settings = std::vector<std::pair<std::string, std::string>>;

  Status Run(const Settings& settings = {}) {
    options_.colmap.colmap = sfm::MakeFakeColmap(folder_.path(), settings);
    return workspace_.Run(*MakeSfmStage(options_, 0));
  }

  nlohmann::json Health(const std::string& folder = "sfm") const {
    return nlohmann::json::parse(
        ReadText(workspace_.path() / folder / "health.json"));
  }

  TemporaryFolder folder_;
  SfmWorkspace workspace_{10};
  SfmStageOptions options_;
};

TEST_F(SfmStageTest, WritesModelHealthAndDatabase) {
  const Status status = Run();
  ASSERT_TRUE(status.ok()) << status.message();
  const fs::path output = workspace_.path() / "sfm";
  const auto model = sfm::ReadModel(output / "sparse" / "0");
  ASSERT_TRUE(model.ok());
  EXPECT_EQ(model->images.size(), 10u);
  EXPECT_TRUE(fs::exists(output / "database.db"));
  EXPECT_TRUE(fs::exists(output / "logs" / "mapper.log"));
  EXPECT_FALSE(fs::exists(output / "steps.json"));
  const nlohmann::json health = Health();
  EXPECT_EQ(health["verdict"], "ok");
  EXPECT_EQ(health["images"], 10);
  EXPECT_EQ(health["registered"], 10);
  EXPECT_EQ(health["models"], 1);
  EXPECT_EQ(health["source"], "colmap");
  EXPECT_EQ(health["colmap_version"], "3.8");
  EXPECT_EQ(health["pairs"]["strategy"], "exhaustive");
  EXPECT_EQ(health["pairs"]["pairs"], 45);
  EXPECT_EQ(health["pairs"]["all_pairs"], 45);
  EXPECT_THAT(health["unregistered"], IsEmpty());
  EXPECT_THAT(workspace_.warnings, IsEmpty());
  EXPECT_EQ(workspace_.summary["registered"], 10);
}

TEST_F(SfmStageTest, LargestModelComesFirst) {
  ASSERT_TRUE(Run({{"FAKE_COLMAP_MODELS", "3,7"}}).ok());
  const fs::path sparse = workspace_.path() / "sfm" / "sparse";
  EXPECT_EQ(sfm::ReadModel(sparse / "0")->images.size(), 7u);
  EXPECT_EQ(sfm::ReadModel(sparse / "1")->images.size(), 3u);
  const nlohmann::json health = Health();
  EXPECT_EQ(health["verdict"], "degraded");
  EXPECT_EQ(health["models"], 2);
  EXPECT_THAT(health["unregistered"], SizeIs(3));
  EXPECT_THAT(workspace_.warnings, Contains(HasSubstr("7 of 10")));
}

TEST_F(SfmStageTest, FewRegisteredIsNotUsable) {
  const Status status =
      Run({{"FAKE_COLMAP_MODELS", "4"}, {"FAKE_COLMAP_RELAXED", "4"}});
  EXPECT_EQ(status.code(), StatusCode::kUnusableResult);
  EXPECT_THAT(status.message(), HasSubstr("4 of 10"));
  EXPECT_THAT(status.message(), HasSubstr("What to try"));
  EXPECT_THAT(status.message(), HasSubstr("health.json and logs/ in "));
  EXPECT_EQ(Health("sfm.partial")["verdict"], "failed");
  EXPECT_FALSE(fs::exists(workspace_.path() / "sfm"));

  options_.health.min_registered_share = 0.3;
  EXPECT_TRUE(
      Run({{"FAKE_COLMAP_MODELS", "4"}, {"FAKE_COLMAP_RELAXED", "4"}}).ok());
}

TEST_F(SfmStageTest, MorePairsAreAdvisedWhereSomeWereNotCompared) {
  const Settings few = {{"FAKE_COLMAP_MODELS", "4"},
                        {"FAKE_COLMAP_RELAXED", "4"}};
  options_.colmap.max_features = 300;  // Else these photos have too few.
  Status status = Run(few);
  EXPECT_THAT(status.message(), HasSubstr("--sfm.camera per_image"));
  EXPECT_THAT(status.message(), Not(HasSubstr("--sfm.matcher")));

  fs::remove_all(workspace_.path() / "sfm.partial");
  options_.colmap.pairs.matcher = "retrieval";
  options_.colmap.pairs.num_neighbours = 2;
  status = Run(few);
  EXPECT_THAT(status.message(), HasSubstr("--sfm.matcher exhaustive"));

  // What is in force is no advice.
  fs::remove_all(workspace_.path() / "sfm.partial");
  options_.colmap.camera = "per_image";
  status = Run(few);
  EXPECT_THAT(status.message(), HasSubstr("--sfm.matcher exhaustive"));
  EXPECT_THAT(status.message(), Not(HasSubstr("--sfm.camera")));
}

TEST_F(SfmStageTest, NoModelIsNotUsable) {
  const Status status = Run({{"FAKE_COLMAP_MODELS", ""}});
  EXPECT_EQ(status.code(), StatusCode::kUnusableResult);
  const nlohmann::json health = Health("sfm.partial");
  EXPECT_EQ(health["models"], 0);
  EXPECT_EQ(health["registered"], 0);
  EXPECT_THAT(health["unregistered"], SizeIs(10));
}

TEST_F(SfmStageTest, MissingColmap) {
  options_.colmap.colmap = "/nonexistent/colmap";
  EXPECT_EQ(workspace_.Run(*MakeSfmStage(options_, 0)).code(),
            StatusCode::kMissingDependency);
}

TEST_F(SfmStageTest, ImportsAColmapModel) {
  sfm::Reconstruction model = sfm::SyntheticModel(10, 30);
  // Under the names that the user knows.
  for (sfm::PosedImage& image : model.images) image.name = "my " + image.name;
  const fs::path source = folder_ / "model";
  ASSERT_TRUE(
      sfm::WriteModel(source / "sparse" / "0", model, sfm::ModelFormat::kText)
          .ok());
  options_.import = source.string();
  options_.colmap.colmap = "/nonexistent/colmap";
  const auto stage = MakeSfmStage(options_, 0);
  EXPECT_THAT(stage->Inputs({}), SizeIs(5));
  const Status status = workspace_.Run(*stage);
  ASSERT_TRUE(status.ok()) << status.message();
  const auto written =
      sfm::ReadModel(workspace_.path() / "sfm" / "sparse" / "0");
  ASSERT_TRUE(written.ok());
  EXPECT_EQ(written->images[3].name, sfm::PhotoName(3));
  EXPECT_EQ(Health()["source"], "imported COLMAP model");
  EXPECT_EQ(Health()["verdict"], "ok");
}

TEST_F(SfmStageTest, PointsWithoutColorsGetThoseOfThePhotos) {
  sfm::Reconstruction model = sfm::SyntheticModel(10, 30);
  for (sfm::Point3D& point : model.points3d) point.rgb = {0, 0, 0};
  model.images[0].points2d[0].xy = {50, 50};  // The files are small.
  const fs::path source = folder_ / "model";
  ASSERT_TRUE(sfm::WriteModel(source, model).ok());
  options_.import = source.string();
  const Status status = workspace_.Run(*MakeSfmStage(options_, 0));
  ASSERT_TRUE(status.ok()) << status.message();
  const auto written =
      sfm::ReadModel(workspace_.path() / "sfm" / "sparse" / "0");
  ASSERT_TRUE(written.ok());
  const bool colored =
      std::any_of(written->points3d.begin(),
                  written->points3d.end(),
                  [](const sfm::Point3D& point) { return point.rgb[1] > 0; });
  EXPECT_TRUE(colored);
}

TEST_F(SfmStageTest, PointsWithoutColorsAndTracksBecomeGrey) {
  sfm::Reconstruction model = sfm::SyntheticModel(10, 30);
  for (sfm::Point3D& point : model.points3d) {
    point.rgb = {0, 0, 0};
    point.track.clear();
  }
  for (sfm::PosedImage& image : model.images) image.points2d.clear();
  const fs::path source = folder_ / "model";
  ASSERT_TRUE(sfm::WriteModel(source, model).ok());
  options_.import = source.string();
  const auto stage = MakeSfmStage(options_, 0);
  Status status = workspace_.Run(*stage);
  ASSERT_TRUE(status.ok()) << status.message();
  const fs::path written = workspace_.path() / "sfm" / "sparse" / "0";
  auto read = sfm::ReadModel(written);
  ASSERT_TRUE(read.ok());
  ASSERT_THAT(read->points3d, SizeIs(30));
  for (const sfm::Point3D& point : read->points3d) {
    EXPECT_THAT(point.rgb, testing::Each(128));
  }
  EXPECT_THAT(Health()["warnings"].dump(), HasSubstr("made grey"));
  EXPECT_THAT(workspace_.warnings, Contains(HasSubstr("made grey")));

  // One colour shows that the program looked for colours.
  model.points3d[7].rgb = {0, 0, 1};
  ASSERT_TRUE(sfm::WriteModel(source, model).ok());
  status = workspace_.Run(*stage);
  ASSERT_TRUE(status.ok()) << status.message();
  read = sfm::ReadModel(written);
  ASSERT_TRUE(read.ok());
  EXPECT_THAT(read->points3d[6].rgb, testing::Each(0));
  EXPECT_THAT(workspace_.warnings, Not(Contains(HasSubstr("made grey"))));
}

// A transforms file of NeRF-synthetic for the photos.
class SfmStageTransformsTest : public SfmStageTest {
 protected:
  SfmStageTransformsTest() {
    std::string frames;
    for (int i = 0; i < 11; ++i) {
      frames += std::string(i > 0 ? "," : "") + R"({"file_path":"./train/)" +
                sfm::PhotoName(i).substr(0, 9) +
                R"(","transform_matrix":[[1,0,0,)" + std::to_string(i) +
                "],[0,0,-1,0],[0,1,0,0],[0,0,0,1]]}";
    }
    const std::string text =
        R"({"camera_angle_x":0.69,"frames":[)" + frames + "]}";
    WriteText(folder_ / "transforms_train.json", text);
    WriteText(
        folder_ / "transforms_test.json",
        R"({"camera_angle_x":0.69,"frames":[{"file_path":"t",)"
        R"("transform_matrix":[[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}]})");
    options_.import = folder_.path().string();
  }
};

TEST_F(SfmStageTransformsTest, RandomPoints) {
  options_.random_points = 123;
  options_.colmap.colmap = "/nonexistent/colmap";
  const Status status = workspace_.Run(*MakeSfmStage(options_, 0));
  ASSERT_TRUE(status.ok()) << status.message();
  EXPECT_EQ(Health()["source"], "imported transforms.json, points random");
  EXPECT_EQ(Health()["num_points"], 123);
  EXPECT_THAT(workspace_.warnings, Contains(HasSubstr("fit no photo")));
}

TEST_F(SfmStageTransformsTest, PhotosThatExifTurnedAreNamed) {
  // The file gives no sizes, so that the quarter turn is not seen either.
  for (int i = 0; i < 5; ++i) workspace_.list.photos[i].orientation = 1 + i;
  workspace_.WriteList();
  options_.random_points = 123;
  const Status status = workspace_.Run(*MakeSfmStage(options_, 0));
  ASSERT_TRUE(status.ok()) << status.message();
  EXPECT_THAT(
      workspace_.warnings,
      Contains(HasSubstr(
          "photo_001.jpg, photo_002.jpg, photo_003.jpg and photo_004.jpg")));
}

TEST_F(SfmStageTransformsTest, HoldoutPhotosAndMasksOfNerfstudioAreNamed) {
  const fs::path file = folder_ / "transforms_train.json";
  std::string text = ReadText(file);
  text.replace(1,
               0,
               R"("test_filenames":["./train/photo_003"],)"
               R"("mask_path":"mask.png",)");
  WriteText(file, text);
  options_.random_points = 123;
  const Status status = workspace_.Run(*MakeSfmStage(options_, 0));
  ASSERT_TRUE(status.ok()) << status.message();
  EXPECT_THAT(workspace_.warnings,
              Contains(testing::AllOf(HasSubstr("test_filenames"),
                                      HasSubstr("photo_003.jpg"))));
  EXPECT_THAT(workspace_.warnings, Contains(HasSubstr("--ingest.masks")));
  EXPECT_TRUE(Health()["mean_reprojection_error_px"].is_null());
}

TEST_F(SfmStageTransformsTest, TriangulatedPoints) {
  const Status status = Run();
  ASSERT_TRUE(status.ok()) << status.message();
  const nlohmann::json health = Health();
  EXPECT_EQ(health["source"], "imported transforms.json, points triangulated");
  EXPECT_EQ(health["num_points"], 150);
  EXPECT_EQ(health["pairs"]["pairs"], 45);
  EXPECT_EQ(health["colmap_version"], "3.8");
  const fs::path output = workspace_.path() / "sfm";
  EXPECT_FALSE(fs::exists(output / "steps.json"));
  const auto model = sfm::ReadModel(output / "sparse" / "0");
  ASSERT_TRUE(model.ok());
  EXPECT_EQ(model->images[3].cam_from_world.translation.x(), -3);
}

TEST_F(SfmStageTransformsTest, FewPointsAreNotTaken) {
  const Status status = Run({{"FAKE_COLMAP_POINTS", "99"}});
  ASSERT_TRUE(status.ok()) << status.message();
  EXPECT_EQ(Health()["source"], "imported transforms.json, points random");
  EXPECT_EQ(Health()["num_points"], 10000);
  EXPECT_THAT(workspace_.warnings, Contains(HasSubstr("only 99 points")));
}

// COLMAP 3.8 aborts then.
TEST_F(SfmStageTransformsTest, WithoutAnyPointTheyAreRandom) {
  const Status status = Run({{"FAKE_COLMAP_POINTS", "0"}});
  ASSERT_TRUE(status.ok()) << status.message();
  EXPECT_EQ(Health()["source"], "imported transforms.json, points random");
  EXPECT_EQ(Health()["num_points"], 10000);
  EXPECT_THAT(workspace_.warnings,
              Contains(HasSubstr("no points were triangulated")));
}

TEST_F(SfmStageTransformsTest, PosesThatDoNotFitDegrade) {
  const Status status =
      Run({{"FAKE_COLMAP_POINTS", "0"}, {"FAKE_COLMAP_DIALECT", "4"}});
  ASSERT_TRUE(status.ok()) << status.message();
  EXPECT_EQ(Health()["verdict"], "degraded");
  EXPECT_THAT(workspace_.warnings,
              Contains(HasSubstr("fits the imported poses")));
}

TEST_F(SfmStageTransformsTest, WithoutColmapPointsAreRandom) {
  options_.colmap.colmap = "/nonexistent/colmap";
  const Status status = workspace_.Run(*MakeSfmStage(options_, 0));
  ASSERT_TRUE(status.ok()) << status.message();
  EXPECT_EQ(Health()["source"], "imported transforms.json, points random");
  EXPECT_THAT(workspace_.warnings, Contains(HasSubstr("/nonexistent/colmap")));
}

TEST_F(SfmStageTest, MissingImportIsBadInput) {
  options_.import = (folder_ / "missing").string();
  const auto stage = MakeSfmStage(options_, 0);
  EXPECT_THAT(stage->Inputs({}), Contains(fs::path(options_.import)));
  EXPECT_EQ(workspace_.Run(*stage).code(), StatusCode::kBadInput);
}

TEST(RegisterSfmOptions, TableIsConsistent) {
  SfmStageOptions options;
  pipeline::OptionTable table;
  RegisterSfmOptions(options, table);
  EXPECT_TRUE(table.Check().ok()) << table.Check().message();
  EXPECT_TRUE(options.colmap.Check().ok());
  for (const auto& option : table.options()) {
    EXPECT_EQ(option.section(), "sfm");
  }
}

}  // namespace
}  // namespace freegs::stages
