// SPDX-License-Identifier: BSD-3-Clause
// Measures of a reconstruction with known truth, and verdicts.

#include "sfm/mapping/health.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/sfm/synthetic_model.h"

namespace freegs::sfm {
namespace {

using testing::AnyOf;
using testing::HasSubstr;
using testing::Not;

std::vector<std::string> Names(int count) {
  std::vector<std::string> names;
  for (int i = 0; i < count; ++i) names.push_back(PhotoName(i));
  return names;
}

TEST(MeasureHealth, PerfectModelIsOk) {
  const Health health =
      MeasureHealth({SyntheticModel(8, 100)}, Names(8), true, {});
  EXPECT_EQ(health.verdict, Verdict::kOk);
  EXPECT_EQ(health.registered, 8);
  EXPECT_EQ(health.measures.observations, 800u);
  EXPECT_NEAR(health.measures.mean_reprojection_error_px, 0, 1e-9);
  EXPECT_EQ(health.measures.median_track_length, 8);
  EXPECT_GT(health.measures.median_triangulation_deg, 90);
  EXPECT_TRUE(health.reason.empty());
}

TEST(MeasureHealth, ReprojectionErrorIsMeasured) {
  Reconstruction model = SyntheticModel(8, 100);
  for (PosedImage& image : model.images) {
    for (Point2D& point : image.points2d) point.xy += Eigen::Vector2d(3, 4);
  }
  const Health health = MeasureHealth({model}, Names(8), true, {});
  EXPECT_NEAR(health.measures.mean_reprojection_error_px, 5, 1e-9);
  EXPECT_EQ(health.verdict, Verdict::kDegraded);
  EXPECT_THAT(health.reason, HasSubstr("reprojection"));
  EXPECT_THAT(health.advice, HasSubstr("camera_model"));

  // Advice names no camera model that is used already.
  for (const char* used : {"OPENCV", "OPENCV_FISHEYE"}) {
    const MappingFacts facts = {.camera_model = used};
    const std::string advice =
        MeasureHealth({model}, Names(8), true, {}, facts).advice;
    EXPECT_THAT(advice + " ",
                Not(HasSubstr("camera_model " + std::string(used) + " ")));
  }

  // COLMAP's options change nothing about imported poses.
  const MappingFacts facts = {.imported = true};
  const Health imported = MeasureHealth({model}, Names(8), true, {}, facts);
  EXPECT_EQ(imported.verdict, Verdict::kDegraded);
  EXPECT_THAT(imported.reason, HasSubstr("5.00 px: the imported poses"));
  EXPECT_THAT(imported.advice, HasSubstr("without sfm.import"));
  for (const int photos : {10, 100}) {  // Degraded and failed.
    const Health partial =
        MeasureHealth({model}, Names(photos), true, {}, facts);
    EXPECT_NE(partial.verdict, Verdict::kOk);
    EXPECT_THAT(partial.advice, HasSubstr("poses for the other photos"));
    EXPECT_THAT(partial.advice, testing::Not(HasSubstr("sfm.matcher")));
  }
}

// As in poses with the camera axes of OpenGL: y and z point the other way.
TEST(MeasureHealth, PointsBehindTheCameras) {
  const auto flipped = [](int count) {
    Reconstruction model = SyntheticModel(10, 100);
    for (int i = 0; i < count; ++i) {
      Rigid3d& pose = model.images[i].cam_from_world;
      const Eigen::Quaterniond flip(0, 1, 0, 0);  // Half a turn about x.
      pose.rotation = flip * pose.rotation;
      pose.translation = flip * pose.translation;
    }
    return MeasureHealth({model}, Names(10), true, {}, {.imported = true});
  };
  const Health all = flipped(10);
  EXPECT_EQ(all.measures.observations, 0u);
  EXPECT_EQ(all.measures.behind, 1000u);
  EXPECT_EQ(all.verdict, Verdict::kFailed);
  EXPECT_THAT(all.reason, HasSubstr("all points lie behind the cameras"));
  EXPECT_THAT(all.advice, HasSubstr("camera axes"));
  const Health some = flipped(2);
  EXPECT_EQ(some.verdict, Verdict::kDegraded);
  EXPECT_THAT(some.reason, HasSubstr("a share of 0.20"));
  EXPECT_THAT(some.advice, HasSubstr("camera axes"));
  EXPECT_EQ(flipped(1).verdict, Verdict::kOk);
}

TEST(MeasureHealth, FewRegistered) {
  const Reconstruction model = SyntheticModel(8, 100);
  EXPECT_EQ(MeasureHealth({model}, Names(9), true, {}).verdict,
            Verdict::kDegraded);  // 89 %.
  const Health health = MeasureHealth({model}, Names(17), true, {});
  EXPECT_EQ(health.verdict, Verdict::kFailed);
  EXPECT_THAT(health.reason, HasSubstr("8 of 17"));
  EXPECT_THAT(health.advice,
              HasSubstr("or try --sfm.max_features 8192, --sfm.matcher "
                        "exhaustive, --sfm.camera per_image"));
  EXPECT_EQ(health.unregistered.size(), 9u);
  MappingFacts facts = {.max_features = 8000};  // No more are advised.
  EXPECT_THAT(MeasureHealth({model}, Names(17), true, {}, facts).advice,
              HasSubstr("or try --sfm.matcher exhaustive, --sfm.camera"));
  facts.all_pairs_compared = true;
  EXPECT_THAT(MeasureHealth({model}, Names(30), true, {}, facts).advice,
              HasSubstr("or try --sfm.camera per_image"));
  // What is in force is no advice.
  facts.camera = "per_image";
  EXPECT_THAT(MeasureHealth({model}, Names(30), true, {}, facts).advice,
              Not(AnyOf(HasSubstr("or try"), HasSubstr("per_image"))));
  const HealthOptions options = {.min_registered_share = 0.4};
  EXPECT_EQ(MeasureHealth({model}, Names(17), true, options).verdict,
            Verdict::kDegraded);
  EXPECT_EQ(MeasureHealth({SyntheticModel(2, 9)}, Names(2), true, {}).verdict,
            Verdict::kFailed);
  const Health none = MeasureHealth({}, Names(5), true, {});
  EXPECT_EQ(none.verdict, Verdict::kFailed);
  EXPECT_THAT(none.reason, HasSubstr("0 of 5"));
}

TEST(MeasureHealth, TurningOnTheSpotFails) {
  Reconstruction model = SyntheticModel(8, 100);
  for (PosedImage& image : model.images) {
    const Eigen::Vector3d centre =
        Eigen::Vector3d(50, 0, 0) + 0.01 * CameraCentre(image.cam_from_world);
    image.cam_from_world.translation =
        -(image.cam_from_world.rotation * centre);
  }
  const Health health = MeasureHealth({model}, Names(8), true, {});
  EXPECT_EQ(health.verdict, Verdict::kFailed);
  EXPECT_THAT(health.reason, HasSubstr("triangulation"));
  // Points without matches have no angle that could be judged.
  EXPECT_EQ(MeasureHealth({model}, Names(8), false, {}).verdict, Verdict::kOk);
}

TEST(HealthToJson, HasTheAgreedNames) {
  Health health = MeasureHealth(
      {SyntheticModel(8, 10), SyntheticModel(3, 5)}, Names(20), true, {});
  health.unregistered.begin()->second = "no matches";
  EXPECT_TRUE(HealthToJson(health)["pairs"].is_null());
  health.pairs = {"retrieval", 50, 190};
  const nlohmann::json json = HealthToJson(health);
  EXPECT_EQ(json["verdict"], "failed");
  EXPECT_EQ(json["images"], 20);
  EXPECT_EQ(json["pairs"]["strategy"], "retrieval");
  EXPECT_EQ(json["pairs"]["pairs"], 50);
  EXPECT_EQ(json["pairs"]["all_pairs"], 190);
  EXPECT_EQ(json["registered"], 8);
  EXPECT_EQ(json["models"], 2);
  EXPECT_EQ(json["model_sizes"], (std::vector<int>{8, 3}));
  EXPECT_EQ(json["unregistered"].size(), 12u);
  EXPECT_EQ(json["unregistered_reasons"].size(), 1u);
  EXPECT_EQ(json["cameras"][0]["model"], "RADIAL");
  EXPECT_THAT(json["advice"].get<std::string>(), HasSubstr("separate models"));
  for (const char* key : {"mean_reprojection_error_px",
                          "median_track_length",
                          "median_triangulation_deg",
                          "registered_share",
                          "num_points",
                          "observations",
                          "warnings",
                          "reason"}) {
    EXPECT_TRUE(json.contains(key)) << key;
  }
}

TEST(HealthToJson, AnErrorThatWasNotMeasuredIsNull) {
  const auto error = [](const Reconstruction& model) {
    return HealthToJson(MeasureHealth({model}, Names(8), false, {}))
        .at("mean_reprojection_error_px");
  };
  Reconstruction model = SyntheticModel(8, 10);
  EXPECT_TRUE(error(model).is_number());
  for (Point3D& point : model.points3d) point.track.clear();
  EXPECT_TRUE(error(model).is_null());

  Health health;
  health.attempts.resize(2);
  health.attempts[1].points = 5;
  health.attempts[1].mean_error_px = 0.5;
  const nlohmann::json attempts = HealthToJson(health).at("attempts");
  EXPECT_TRUE(attempts[0]["mean_reprojection_error_px"].is_null());
  EXPECT_EQ(attempts[1]["mean_reprojection_error_px"], 0.5);
}

TEST(HealthToJson, HasTheTableOfCameras) {
  Health health = MeasureHealth({SyntheticModel(8, 10)}, Names(8), true, {});
  EXPECT_TRUE(HealthToJson(health)["camera_models"].empty());
  CameraCandidate candidate;
  candidate.model = CameraModel::kSimpleRadial;
  candidate.sharing = CameraSharing::kPerGroup;
  candidate.parameters = 4;
  candidate.held_out_error_px = 0.75;
  candidate.bic = -12.5;
  candidate.chosen = true;
  health.camera_models = {candidate, {}};
  health.camera_models[1].refused = "the distortion turns back";
  const nlohmann::json json = HealthToJson(health);
  const nlohmann::json& rows = json["camera_models"];
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[0]["model"], "SIMPLE_RADIAL");
  EXPECT_EQ(rows[0]["sharing"], "per_group");
  EXPECT_EQ(rows[0]["parameters"], 4);
  EXPECT_EQ(rows[0]["held_out_error_px"], 0.75);
  EXPECT_EQ(rows[0]["bic"], -12.5);
  EXPECT_EQ(rows[0]["chosen"], true);
  EXPECT_FALSE(rows[0].contains("reason"));
  EXPECT_EQ(rows[1]["reason"], "the distortion turns back");
}

}  // namespace
}  // namespace freegs::sfm
