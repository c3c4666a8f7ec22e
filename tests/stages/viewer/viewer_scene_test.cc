// SPDX-License-Identifier: BSD-3-Clause

#include "stages/viewer/viewer_scene.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "core/base64.h"
#include "splat/scene/ply_io.h"
#include "splat/scene/spz_format.h"
#include "stages/scene/workspace_scene.h"
#include "tests/stages/synthetic_workspace.h"

namespace freegs::stages {
namespace {

using nlohmann::json;

class ViewerSceneTest : public testing::Test {
 protected:
  static int At(const std::string& labels, size_t index) {
    return static_cast<uint8_t>(labels[2 * index]) |
           static_cast<uint8_t>(labels[2 * index + 1]) << 8;
  }

  // What the page shows of this model, in its first part.
  StatusOr<splat::GaussianModel> Shown(
      const splat::GaussianModel& model) const {
    FREEGS_RETURN_IF_ERROR(
        splat::WritePly(workspace_ / "reconstruct" / "point_cloud.ply", model));
    FREEGS_ASSIGN_OR_RETURN(const ViewerScene scene,
                            MakeViewerScene(workspace_.path(), {}));
    return splat::ParseSpz(scene.parts[0].splats, false);
  }

  SyntheticWorkspace workspace_;
};

TEST_F(ViewerSceneTest, PartsHoldAllGaussiansAndTheirLabels) {
  workspace_.AddInstances();
  workspace_.AddHierarchy();
  const auto scene = MakeViewerScene(workspace_.path(), {.part_size = 60});
  ASSERT_TRUE(scene.ok()) << scene.status().message();
  ASSERT_EQ(scene->parts.size(), 3u);
  EXPECT_EQ(scene->description["num_gaussians"], 120);
  int of_instance[4] = {0, 0, 0, 0};
  double last = INFINITY;
  for (size_t p = 0; p < 3; ++p) {
    const auto model = splat::ParseSpz(scene->parts[p].splats, false);
    ASSERT_TRUE(model.ok());
    EXPECT_EQ(scene->description["parts"][p]["num_gaussians"], model->size());
    ASSERT_EQ(scene->parts[p].labels.size(), 4 * model->size());
    double covered = 0;
    for (size_t g = 0; g < model->size(); ++g) {
      const int id = At(scene->parts[p].labels, 2 * g);
      ASSERT_LE(id, 3);
      ++of_instance[id];
      // Two parts for each instance, those of the third come first.
      const int first[] = {0, 2, 4, 0};
      const int part = At(scene->parts[p].labels, 2 * g + 1);
      EXPECT_EQ(part, id == 0 ? 65535 : first[id] + part % 2);
      double volume = 0;
      for (int k = 0; k < 3; ++k) volume += model->log_scales[3 * g + k];
      covered += volume / static_cast<double>(model->size());
    }
    EXPECT_LT(covered, last);
    last = covered;
  }
  for (const int count : of_instance) EXPECT_EQ(count, 30);
  // Instances 1 and 2 are a group, then all three.
  const json& levels = scene->description["levels"];
  EXPECT_EQ(levels["1"]["wider"], json::parse("[[2, 6], [0, 6]]"));
  EXPECT_EQ(levels["3"]["wider"], json::parse("[[0, 6]]"));
}

// One Gaussian that is very far away spoils neither the page nor the others.
TEST_F(ViewerSceneTest, ShowsWhatIsVeryFarAway) {
  const auto plain = MakeViewerScene(workspace_.path(), {});
  ASSERT_TRUE(plain.ok());
  const auto expected = splat::ParseSpz(plain->parts[0].splats, false);
  splat::GaussianModel model = workspace_.model;
  for (int k = 0; k < 3; ++k) model.means[k] = k == 0 ? 1e12f : 0;
  for (int k = 0; k < 3; ++k) model.log_scales[k] = 20;
  const auto shown = Shown(model);
  ASSERT_TRUE(shown.ok() && expected.ok());
  ASSERT_EQ(shown->size(), expected->size());
  EXPECT_NEAR(shown->means[0], 32767, 1);
  EXPECT_NEAR(shown->log_scales[0], 20 + std::log(32767 / 1e12), 0.04);
  for (size_t i = 3; i < shown->means.size(); ++i) {
    EXPECT_NEAR(shown->means[i], expected->means[i], 1.1 / 512);
  }
}

// The format has deviations of up to 379 units.
TEST_F(ViewerSceneTest, WhatIsFarAndLargeKeepsItsSizeInTheView) {
  splat::GaussianModel model = workspace_.model;
  for (int k = 0; k < 3; ++k) model.means[k] = k == 2 ? 4000 : 0;
  for (int k = 0; k < 3; ++k) model.log_scales[k] = std::log(1500.0f);
  // Hills before the sky.
  for (int k = 3; k < 6; ++k) model.means[k] = k == 5 ? 1300 : 0;
  for (int k = 3; k < 6; ++k) model.log_scales[k] = std::log(50.0f);
  const auto shown = Shown(model);
  ASSERT_TRUE(shown.ok());
  const auto largest =
      std::max_element(shown->log_scales.begin(), shown->log_scales.end());
  const size_t g = (largest - shown->log_scales.begin()) / 3;
  EXPECT_NEAR(*largest - std::log(shown->means[3 * g + 2]),
              std::log(1500.0 / 4000),
              0.04);
  // Nothing came to stand behind the sky, and the hills look as large as
  // before.
  size_t hill = 0;
  for (size_t i = 0; i < shown->size(); ++i) {
    const float z = shown->means[3 * i + 2];
    EXPECT_LE(z, shown->means[3 * g + 2]);
    if (i != g && z > 500) hill = i;
  }
  ASSERT_GT(shown->means[3 * hill + 2], 500);
  EXPECT_NEAR(
      shown->log_scales[3 * hill] - std::log(shown->means[3 * hill + 2]),
      std::log(50.0 / 1300),
      0.04);
}

TEST_F(ViewerSceneTest, FollowsTheContract) {
  workspace_.AddInstances();
  const auto scene = MakeViewerScene(
      workspace_.path(), {.pictures = {{"photo1.png", "views/1_photo.jpg"}}});
  ASSERT_TRUE(scene.ok()) << scene.status().message();
  const json& d = scene->description;
  EXPECT_EQ(d["format"], "freegs-viewer-scene");
  EXPECT_EQ(d["version"], 1);
  EXPECT_EQ(d["background"], json::parse("[1, 1, 1]"));
  ASSERT_EQ(d["photos"].size(), 6u);
  EXPECT_EQ(d["photos"][0]["name"], "a <b>&'c#d.png");
  EXPECT_EQ(d["photos"][0]["holdout"], true);
  EXPECT_EQ(d["photos"][1]["image"], "views/1_photo.jpg");
  EXPECT_EQ(d["photos"][2]["image"], "");
  ASSERT_EQ(d["objects"].size(), 3u);
  EXPECT_EQ(d["objects"][0]["color"].size(), 3u);
  EXPECT_TRUE(d["levels"].empty());

  // A Gaussian, a photo and a box are where the world has them.
  const auto world = ReadWorkspaceScene(workspace_.path());
  ASSERT_TRUE(world.ok());
  const double unit = d["unit"];
  const json& box = d["objects"][1]["obb"];
  const semantics::Instance& instance = workspace_.instances[1];
  for (int k = 0; k < 3; ++k) {
    const double origin = d["origin"][k];
    EXPECT_NEAR(unit * box["center"][k].get<double>() + origin,
                instance.obb.centre[k],
                1e-5);
    EXPECT_NEAR(
        unit * box["size"][k].get<double>(), instance.obb.size[k], 1e-5);
  }
}

TEST_F(ViewerSceneTest, LeavesOutWhatDoesNotFit) {
  const auto whole = MakeViewerScene(workspace_.path(), {});
  ASSERT_TRUE(whole.ok());
  EXPECT_EQ(whole->description["sh_degree"], 1);
  const auto small = MakeViewerScene(workspace_.path(), {.max_bytes = 1});
  ASSERT_TRUE(small.ok());
  EXPECT_EQ(small->description["sh_degree"], 0);
  EXPECT_LT(small->parts[0].splats.size(), whole->parts[0].splats.size());
}

TEST_F(ViewerSceneTest, ScriptHoldsTheSameBytes) {
  const auto scene = MakeViewerScene(workspace_.path(), {});
  ASSERT_TRUE(scene.ok());
  const std::string script = ViewerSceneScript(*scene);
  const std::string start = "globalThis.freegsScene = ";
  ASSERT_TRUE(script.starts_with(start));
  const json parsed = json::parse(script.substr(start.size()));
  EXPECT_EQ(parsed["description"], scene->description);
  EXPECT_EQ(
      DecodeBase64(parsed["parts"][0]["splats"].get<std::string>()).value(),
      scene->parts[0].splats);
}

TEST_F(ViewerSceneTest, ErrorsNameWhatIsMissing) {
  EXPECT_EQ(
      MakeViewerScene(workspace_.path(), {.part_size = 0}).status().code(),
      StatusCode::kInvalidArgument);
  CancellationToken cancelled;
  cancelled.Cancel();
  EXPECT_EQ(MakeViewerScene(workspace_.path(), {.cancellation = &cancelled})
                .status()
                .code(),
            StatusCode::kInterrupted);
  std::filesystem::remove(workspace_.path() / "reconstruct/point_cloud.ply");
  const auto scene = MakeViewerScene(workspace_.path(), {});
  EXPECT_EQ(scene.status().code(), StatusCode::kBadInput);
  EXPECT_NE(scene.status().message().find("point_cloud.ply"),
            std::string::npos);
}

}  // namespace
}  // namespace freegs::stages
