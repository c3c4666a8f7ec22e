// SPDX-License-Identifier: BSD-3-Clause
// The frame of a scene from cameras whose up direction is known.

#include "sfm/scene/scene_frame.h"

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <numbers>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/random.h"
#include "sfm/scene/model_io.h"
#include "sfm/scene/pose_alignment.h"
#include "tests/sfm/synthetic_model.h"
#include "tests/shared_data.h"

namespace freegs::sfm {
namespace {

namespace fs = std::filesystem;

constexpr double kDegree = std::numbers::pi / 180;

double AngleDeg(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::acos(std::clamp(a.normalized().dot(b.normalized()), -1.0, 1.0)) /
         kDegree;
}

// A camera at `centre` that looks at `target` and is held level (z is up), then
// rolled about its axis.
Rigid3d LevelCamera(const Eigen::Vector3d& centre,
                    const Eigen::Vector3d& target,
                    double roll_deg = 0) {
  const Eigen::Vector3d z = (target - centre).normalized();
  Eigen::Vector3d x = z.cross(Eigen::Vector3d::UnitZ());
  if (x.norm() < 1e-9) x = Eigen::Vector3d::UnitX();
  Eigen::Matrix3d rotation;
  rotation.row(0) = x.normalized();
  rotation.row(1) = z.cross(x.normalized());
  rotation.row(2) = z;
  rotation = Eigen::AngleAxisd(roll_deg * kDegree, Eigen::Vector3d::UnitZ())
                 .toRotationMatrix() *
             rotation;
  Rigid3d pose;
  pose.rotation = Eigen::Quaterniond(rotation);
  pose.translation = -(pose.rotation * centre);
  return pose;
}

// The model with these poses, without points.
Reconstruction ModelOf(const std::vector<Rigid3d>& poses) {
  Reconstruction model = SyntheticModel(static_cast<int>(poses.size()), 0);
  for (size_t i = 0; i < poses.size(); ++i) {
    model.images[i].cam_from_world = poses[i];
  }
  return model;
}

// Cameras around the origin, 1.5 above it, each rolled by some degrees.
std::vector<Rigid3d> Ring(int count, double roll_sigma_deg) {
  std::vector<Rigid3d> poses;
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * std::numbers::pi * i / count;
    poses.push_back(LevelCamera({3 * std::cos(angle), 3 * std::sin(angle), 1.5},
                                {0, 0, 0},
                                roll_sigma_deg * RandomNormal(3, 1, i)));
  }
  return poses;
}

SceneFrame Estimate(const Reconstruction& model) {
  const auto frame = EstimateSceneFrame(model);
  EXPECT_TRUE(frame.ok()) << frame.status().message();
  return frame.ok() ? *frame : SceneFrame();
}

TEST(SceneFrame, RingOfLevelCameras) {
  const SceneFrame frame = Estimate(ModelOf(Ring(24, 1)));
  EXPECT_EQ(frame.source, UpSource::kHorizon);
  EXPECT_LT(AngleDeg(frame.up, Eigen::Vector3d::UnitZ()), 1);
  EXPECT_GT(frame.confidence, 0.9);
  EXPECT_GT(frame.tilt_rms_deg, 0.3);
  EXPECT_LT(frame.tilt_rms_deg, 2);
  EXPECT_LT(frame.centre.norm(), 0.1);
  EXPECT_NEAR(frame.distance, std::sqrt(9 + 1.5 * 1.5), 0.05);
  EXPECT_FALSE(frame.ground.has_value());
}

// So many that pairs of cameras are drawn instead of all taken.
TEST(SceneFrame, ManyCameras) {
  const SceneFrame frame = Estimate(ModelOf(Ring(100, 1)));
  EXPECT_EQ(frame.source, UpSource::kHorizon);
  EXPECT_LT(AngleDeg(frame.up, Eigen::Vector3d::UnitZ()), 1);
  EXPECT_GT(frame.confidence, 0.9);
}

// The same scene in another world: turned, scaled, moved. The frame undoes it.
TEST(SceneFrame, MatrixMapsAnyWorldToTheSameFrame) {
  const std::vector<Rigid3d> poses = Ring(12, 0);
  const SceneFrame first = Estimate(ModelOf(poses));
  const Eigen::Quaterniond turn(
      Eigen::AngleAxisd(2, Eigen::Vector3d(1, -2, 0.5).normalized()));
  const Eigen::Vector3d shift(5, -7, 3);
  const double scale = 0.2;
  std::vector<Rigid3d> moved;
  for (const Rigid3d& pose : poses) {
    Rigid3d other;
    other.rotation = pose.rotation * turn.conjugate();
    const Eigen::Vector3d centre = scale * (turn * CameraCentre(pose)) + shift;
    other.translation = -(other.rotation * centre);
    moved.push_back(other);
  }
  const SceneFrame second = Estimate(ModelOf(moved));
  EXPECT_LT(AngleDeg(second.up, turn * first.up), 1e-4);
  EXPECT_NEAR(second.distance, scale * first.distance, 1e-4);
  const Eigen::Matrix3d block = second.frame_from_world.topLeftCorner<3, 3>();
  EXPECT_NEAR((block * second.distance).determinant(), 1, 1e-9);
  for (size_t i = 0; i < poses.size(); ++i) {
    const Eigen::Vector4d a =
        first.frame_from_world * CameraCentre(poses[i]).homogeneous();
    const Eigen::Vector4d b =
        second.frame_from_world * CameraCentre(moved[i]).homogeneous();
    EXPECT_LT((a - b).norm(), 1e-3);
    EXPECT_NEAR(a[2], 1.5 / first.distance, 0.02);
  }
}

TEST(SceneFrame, CamerasHeldOtherwiseAreOutvoted) {
  std::vector<Rigid3d> poses = Ring(30, 1);
  for (int i = 0; i < 30; i += 3) {
    const Eigen::Vector3d centre = CameraCentre(poses[i]);
    poses[i] = LevelCamera(centre, {0, 0, 0}, i % 2 == 0 ? 90 : 37);
  }
  const SceneFrame frame = Estimate(ModelOf(poses));
  EXPECT_LT(AngleDeg(frame.up, Eigen::Vector3d::UnitZ()), 1);
  EXPECT_NEAR(frame.confidence, 2.0 / 3, 0.05);
}

TEST(SceneFrame, OneCameraIsAGuess) {
  const SceneFrame frame =
      Estimate(ModelOf({LevelCamera({3, 0, 0}, {0, 0, 0})}));
  EXPECT_EQ(frame.source, UpSource::kCameraUp);
  EXPECT_LT(AngleDeg(frame.up, Eigen::Vector3d::UnitZ()), 0.1);
  EXPECT_LE(frame.confidence, 0.3);
  EXPECT_TRUE(frame.frame_from_world.allFinite());
}

TEST(SceneFrame, ParallelCameras) {
  std::vector<Rigid3d> poses;
  for (int i = 0; i < 10; ++i) {
    poses.push_back(LevelCamera({0.3 * i, 0, 1}, {0.3 * i, 5, 1}));
  }
  const SceneFrame frame = Estimate(ModelOf(poses));
  EXPECT_EQ(frame.source, UpSource::kCameraUp);
  EXPECT_LT(AngleDeg(frame.up, Eigen::Vector3d::UnitZ()), 0.1);
  EXPECT_LE(frame.confidence, 0.3);
}

// A drone that looks straight down and turns.
TEST(SceneFrame, AllLookingDown) {
  std::vector<Rigid3d> poses;
  for (int i = 0; i < 20; ++i) {
    poses.push_back(LevelCamera(
        {0.2 * i, 0.1 * (i % 4), 3}, {0.2 * i, 0.1 * (i % 4), 0}, 18.0 * i));
  }
  const SceneFrame frame = Estimate(ModelOf(poses));
  EXPECT_LT(AngleDeg(frame.up, Eigen::Vector3d::UnitZ()), 0.1);
  EXPECT_LE(frame.confidence, 0.1);
}

// One camera turned about its own axis: the same axes as above, but level ones
// would be a lie. It cannot be told apart, only doubted.
TEST(SceneFrame, PureRollIsDoubted) {
  std::vector<Rigid3d> poses;
  for (int i = 0; i < 20; ++i) {
    poses.push_back(LevelCamera({3, 0, 0}, {0, 0, 0}, 18.0 * i));
  }
  const SceneFrame frame = Estimate(ModelOf(poses));
  EXPECT_LE(frame.confidence, 0.1);
  EXPECT_NEAR(frame.up.norm(), 1, 1e-9);
  EXPECT_TRUE(frame.frame_from_world.allFinite());
}

TEST(SceneFrame, GroundPlaneIsACheck) {
  Reconstruction model = ModelOf(Ring(12, 0.5));
  RandomStream random(1, 2);
  for (int i = 0; i < 300; ++i) {
    Point3D point;
    point.id = i + 1;
    point.xyz = {4 * random.Uniform() - 2, 4 * random.Uniform() - 2, -0.5};
    if (i % 2 == 0) point.xyz.z() += random.Uniform();
    model.points3d.push_back(point);
  }
  const SceneFrame frame = Estimate(model);
  ASSERT_TRUE(frame.ground.has_value());
  EXPECT_LT(frame.ground->angle_to_up_deg, 3);
  EXPECT_NEAR(frame.ground->point_share, 0.52, 0.05);
}

TEST(SceneFrame, JsonHasTheMatrixByRows) {
  const SceneFrame frame = Estimate(ModelOf(Ring(12, 0)));
  const auto json = SceneFrameToJson(frame);
  ASSERT_EQ(json["frame_from_world"].size(), 16u);
  EXPECT_EQ(json["frame_from_world"][3].get<double>(),
            frame.frame_from_world(0, 3));
  EXPECT_EQ(json["up_source"], "horizon");
  EXPECT_EQ(json["metric"], false);
  EXPECT_TRUE(json["ground"].is_null());
  EXPECT_FALSE(EstimateSceneFrame(Reconstruction()).ok());
}

// Rendered scenes whose true cameras are known, in metres with z up.
// FREEGS_FRAME_MODELS may name folders with reconstructions of them,
// NAME/sfm/sparse/0, whose up is then compared, too.
TEST(SceneFrame, TrueUpOfRenderedScenes) {
  const fs::path data = SharedData("");
  if (data.empty()) GTEST_SKIP() << "FREEGS_SHARED_DATA is not set";
  const char* models = std::getenv("FREEGS_FRAME_MODELS");
  for (const char* scene : {"tabletop", "playroom"}) {
    std::ifstream file(data / scene / "gt" / "cameras.json");
    if (!file) continue;
    const auto json = nlohmann::json::parse(file, nullptr, false);
    ASSERT_FALSE(json.is_discarded());
    std::vector<Rigid3d> poses;
    NamedPoses truth;
    for (const auto& [name, rows] : json["train"].items()) {
      Eigen::Matrix4d matrix;
      for (int i = 0; i < 4; ++i) {
        for (int j = 0; j < 4; ++j) matrix(i, j) = rows[i][j].get<double>();
      }
      Rigid3d pose;
      pose.rotation =
          Eigen::Quaterniond(Eigen::Matrix3d(matrix.topLeftCorner<3, 3>()));
      pose.translation = matrix.topRightCorner<3, 1>();
      poses.push_back(pose);
      truth[name] = pose;
    }
    const SceneFrame frame = Estimate(ModelOf(poses));
    const double angle = AngleDeg(frame.up, Eigen::Vector3d::UnitZ());
    std::printf("%s: true cameras, up off by %.3f degrees, confidence %.2f\n",
                scene,
                angle,
                frame.confidence);
    EXPECT_LT(angle, 2);
    if (models == nullptr) continue;
    const auto model =
        ReadModel(fs::path(models) / scene / "sfm" / "sparse" / "0");
    if (!model.ok()) continue;
    NamedPoses found;
    for (const PosedImage& image : model->images) {
      found[image.name] = image.cam_from_world;
    }
    const auto alignment = AlignPoses(found, truth);
    ASSERT_TRUE(alignment.ok()) << alignment.status().message();
    const SceneFrame reconstructed = Estimate(*model);
    const double off =
        AngleDeg(alignment->target_from_source.rotation * reconstructed.up,
                 Eigen::Vector3d::UnitZ());
    std::printf(
        "%s: COLMAP's cameras, up off by %.3f degrees, confidence %.2f, one "
        "unit %.3f m, ground %.2f degrees from up\n",
        scene,
        off,
        reconstructed.confidence,
        alignment->target_from_source.scale * reconstructed.distance,
        reconstructed.ground ? reconstructed.ground->angle_to_up_deg : -1);
    EXPECT_LT(off, 2);
  }
}

}  // namespace
}  // namespace freegs::sfm
