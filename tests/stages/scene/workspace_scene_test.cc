// SPDX-License-Identifier: BSD-3-Clause

#include "stages/scene/workspace_scene.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pipeline/stage_record.h"
#include "tests/stages/synthetic_workspace.h"

namespace freegs::stages {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

std::vector<View> Named(const std::vector<std::string>& names) {
  std::vector<View> views;
  for (const std::string& name : names) {
    views.emplace_back();
    views.back().name = name;
  }
  return views;
}

TEST(WorkspaceSceneTest, SplitsAndTrainingOptions) {
  const SyntheticWorkspace workspace(7);
  const auto scene = ReadWorkspaceScene(workspace.path());
  ASSERT_TRUE(scene.ok()) << scene.status().message();
  EXPECT_EQ(scene->model.size(), workspace.model.size());
  ASSERT_EQ(scene->holdout.size(), 3u);
  ASSERT_EQ(scene->train.size(), 4u);
  EXPECT_EQ(scene->holdout[1].name, "photo3.png");
  EXPECT_EQ(scene->holdout[1].camera.width, SyntheticWorkspace::kWidth);
  EXPECT_EQ(scene->training_max_side, SyntheticWorkspace::kTrainingSide);
  EXPECT_EQ(scene->render.background[0], 1.0f);
}

TEST(WorkspaceSceneTest, SomebodyElsesModel) {
  const SyntheticWorkspace workspace;
  std::filesystem::remove_all(workspace / "ingest");
  std::filesystem::remove(workspace / "reconstruct" / "stage.json");
  const auto scene = ReadWorkspaceScene(workspace.path());
  ASSERT_TRUE(scene.ok()) << scene.status().message();
  EXPECT_TRUE(scene->holdout.empty());
  EXPECT_EQ(scene->train.size(), 6u);
  EXPECT_EQ(scene->training_max_side, 0);
  EXPECT_EQ(scene->render.background[0], 0.0f);
}

// The file of older programs has the transpose of each matrix.
TEST(WorkspaceSceneTest, ExposuresOfOlderPrograms) {
  SyntheticWorkspace workspace;
  const std::filesystem::path folder = workspace.path() / "reconstruct";
  WriteText(folder / "exposure.json",
            R"({"a.png": [[1, 0.2, 0, 0.3], [0, 1, 0, 0], [0, 0, 1, 0]]})");
  StatusOr<pipeline::StageRecord> record = pipeline::ReadStageRecord(folder);
  ASSERT_TRUE(record.ok());
  for (const int version : {13, 14}) {
    record->fingerprint.version = version;
    ASSERT_TRUE(pipeline::WriteStageRecord(folder, *record).ok());
    const auto scene = ReadWorkspaceScene(workspace.path());
    ASSERT_TRUE(scene.ok()) << scene.status().message();
    const auto& values = scene->exposures[0].color.values;
    // Red of the photo takes green of the scene, or the other way round.
    EXPECT_EQ(values[1], version == 13 ? 0.2f : 0.0f);
    EXPECT_EQ(values[4], version == 13 ? 0.0f : 0.2f);
    EXPECT_EQ(values[3], 0.3f);
  }
}

TEST(WorkspaceSceneTest, MissingAndDamagedFilesAreNamed) {
  const SyntheticWorkspace workspace;
  WriteText(workspace / "ingest" / "images.json", "{");
  EXPECT_THAT(ReadWorkspaceScene(workspace.path()).status().message(),
              HasSubstr("images.json"));
  std::filesystem::remove_all(workspace / "undistort");
  const Status status = ReadWorkspaceScene(workspace.path()).status();
  EXPECT_EQ(status.code(), StatusCode::kBadInput);
  EXPECT_THAT(status.message(), HasSubstr("run stage undistort"));
}

TEST(OutputNamesTest, ReplacesTheExtension) {
  const auto names =
      OutputNames(Named({"a.jpg", "sub/b.c.JPG", "no_suffix"}), ".png");
  ASSERT_TRUE(names.ok());
  EXPECT_THAT(*names, ElementsAre("a.png", "sub/b.c.png", "no_suffix.png"));
}

TEST(OutputNamesTest, KeepsTheExtensionWhereNamesWouldCollide) {
  const auto names = OutputNames(Named({"a.jpg", "a.png", "b.png"}), "");
  ASSERT_TRUE(names.ok());
  EXPECT_THAT(*names, ElementsAre("a.jpg", "a.png", "b"));
  const auto more =
      OutputNames(Named({"a.jpg", "a.png", "a.jpg.jpg", "b.png"}), ".png");
  ASSERT_TRUE(more.ok());
  EXPECT_THAT(*more,
              ElementsAre("a.jpg.png", "a.png.png", "a.jpg.jpg.png", "b.png"));
}

TEST(OutputNamesTest, AViewIsFoundByItsName) {
  const auto names = OutputNameByView(Named({"a.jpg", "b.png", "a.png"}), "");
  ASSERT_TRUE(names.ok());
  EXPECT_EQ(names->size(), 3u);
  EXPECT_EQ(names->at("a.png"), "a.png");
  EXPECT_EQ(names->at("b.png"), "b");
  EXPECT_FALSE(OutputNameByView(Named({"../a"}), "").ok());
}

TEST(OutputNamesTest, RefusesOneFileForTwoViews) {
  for (const auto& views : {std::vector<std::string>{"./a.png", "a.png"},
                            {"b/a.png", "b//a.png"},
                            {"a.jpg", "a.png/b.jpg"}}) {
    const Status status = OutputNames(Named(views), ".png").status();
    EXPECT_EQ(status.code(), StatusCode::kBadInput) << views[0];
    EXPECT_NE(status.message().find(views[0]), std::string::npos);
  }
  // Folders may lie in each other.
  EXPECT_TRUE(OutputNames(Named({"a.jpg", "a/b.jpg"}), "").ok());
}

TEST(OutputNamesTest, RefusesNamesThatLeaveTheFolder) {
  for (const char* name : {"", "/etc/x.png", "../x.png", "a/../../x", "a/"}) {
    EXPECT_EQ(OutputNames(Named({name}), ".png").status().code(),
              StatusCode::kBadInput)
        << name;
  }
}

}  // namespace
}  // namespace freegs::stages
