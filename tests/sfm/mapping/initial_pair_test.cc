// SPDX-License-Identifier: BSD-3-Clause
// The motion between two photos, and the pair with which mapping begins.

#include "sfm/mapping/initial_pair.h"

#include <algorithm>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <memory>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/random.h"
#include "tests/sfm/fake_colmap.h"
#include "tests/sfm/match_database_writer.h"
#include "tests/sfm/synthetic_model.h"
#include "tests/temporary_folder.h"

namespace freegs::sfm {
namespace {

namespace fs = std::filesystem;

constexpr int kNumPoints = 200;
constexpr int kWidth = 640;
constexpr int kHeight = 480;
constexpr double kFocal = 600;

Eigen::Matrix3d Cross(const Eigen::Vector3d& t) {
  Eigen::Matrix3d cross;
  cross << 0, -t.z(), t.y(), t.z(), 0, -t.x(), -t.y(), t.x(), 0;
  return cross;
}

Eigen::Matrix3d Intrinsics() {
  Eigen::Matrix3d intrinsics;
  intrinsics << kFocal, 0, kWidth / 2.0, 0, kFocal, kHeight / 2.0, 0, 0, 1;
  return intrinsics;
}

// Points around the origin, half of them on a plane.
std::vector<Eigen::Vector3d> MakePoints() {
  RandomStream random(11, 1);
  std::vector<Eigen::Vector3d> points;
  for (int k = 0; k < kNumPoints; ++k) {
    points.push_back({2 * random.Uniform() - 1,
                      2 * random.Uniform() - 1,
                      k % 2 == 0 ? 0.0 : 0.8 * random.Uniform()});
  }
  return points;
}

TEST(InitialPair, MotionOfTwoPhotos) {
  const std::vector<Eigen::Vector3d> points = MakePoints();
  const Rigid3d first = LookAt({3, 1, 2}, {0, 0, 0});
  for (const Eigen::Vector3d& centre : {Eigen::Vector3d(3, 2, 2),
                                        Eigen::Vector3d(2, -1, 2.5),
                                        Eigen::Vector3d(3, 1, 2.4),
                                        Eigen::Vector3d(1.5, 0.5, 1)}) {
    const Rigid3d second = LookAt(centre, {0.1, 0, 0});
    const Rigid3d motion = second * Inverse(first);
    Eigen::Matrix3Xd rays1(3, kNumPoints);
    Eigen::Matrix3Xd rays2(3, kNumPoints);
    std::vector<double> angles;
    for (int k = 0; k < kNumPoints; ++k) {
      rays1.col(k) = (first * points[k]).hnormalized().homogeneous();
      rays2.col(k) = (second * points[k]).hnormalized().homogeneous();
      const Eigen::Vector3d a = points[k] - Eigen::Vector3d(3, 1, 2);
      const Eigen::Vector3d b = points[k] - centre;
      angles.push_back(std::acos(a.normalized().dot(b.normalized())) * 180 /
                       std::numbers::pi);
    }
    std::sort(angles.begin(), angles.end());
    // The sign and the size of the matrix tell nothing.
    for (const double scale : {1.0, -0.3}) {
      const PairMotion found =
          MeasureMotion(scale * Cross(motion.translation) *
                            motion.rotation.toRotationMatrix(),
                        rays1,
                        rays2);
      EXPECT_EQ(found.in_front, kNumPoints);
      EXPECT_NEAR(found.angle_deg, angles[kNumPoints / 2], 1e-6);
      EXPECT_NEAR(
          found.forward, std::abs(motion.translation.normalized().z()), 1e-9);
    }
  }
}

TEST(InitialPair, NoMotionIsHarmless) {
  const Eigen::Matrix3Xd rays = Eigen::Matrix3Xd::Ones(3, 10);
  EXPECT_EQ(MeasureMotion(Eigen::Matrix3d::Zero(), rays, rays).angle_deg, 0);
  EXPECT_EQ(MeasureMotion(Eigen::Matrix3d::Identity(),
                          Eigen::Matrix3Xd(3, 0),
                          Eigen::Matrix3Xd(3, 0))
                .in_front,
            0);
}

// Photos k = 1, 2, ... of the same points, and the matches of their pairs.
class ChooseInitialPairTest : public testing::Test {
 protected:
  void AddPhoto(const Eigen::Vector3d& centre) {
    const auto id = static_cast<int>(photos_.size()) + 1;
    SfmPhoto photo;
    photo.name = PhotoName(id);
    photo.width = kWidth;
    photo.height = kHeight;
    photo.focal_px = kFocal;
    photos_.push_back(photo);
    poses_.push_back(LookAt(centre, {0, 0, 0}));
    std::vector<float> features;
    for (const Eigen::Vector3d& point : points_) {
      const Eigen::Vector2d pixel =
          (Intrinsics() * (poses_.back() * point)).hnormalized();
      features.push_back(static_cast<float>(pixel.x()));
      features.push_back(static_cast<float>(pixel.y()));
    }
    writer_->AddPhoto(id, photo.name, features);
  }

  // Every `step`-th point is a match, beginning with `first`.
  void Match(int id1, int id2, int first, int step) {
    const Rigid3d motion = poses_[id2 - 1] * Inverse(poses_[id1 - 1]);
    const Eigen::Matrix3d inverse = Intrinsics().inverse();
    const Eigen::Matrix3d rotation = motion.rotation.toRotationMatrix();
    // The plane z = 0 in the frame of the first camera: normal . x = distance.
    const Eigen::Vector3d normal =
        poses_[id1 - 1].rotation * Eigen::Vector3d::UnitZ();
    const double distance = normal.dot(poses_[id1 - 1].translation);
    const Eigen::Matrix3d homography =
        Intrinsics() *
        (rotation + motion.translation * normal.transpose() / distance) *
        inverse;
    const Eigen::Matrix3d fundamental =
        inverse.transpose() * Cross(motion.translation) * rotation * inverse;
    std::vector<uint32_t> matches;
    for (int k = first; k < kNumPoints; k += step) {
      matches.insert(matches.end(), 2, static_cast<uint32_t>(k));
    }
    // Features that do not exist.
    matches.insert(matches.end(), {4000000000u, 1u, 2u, kNumPoints});
    writer_->Add(id1, id2, matches, 2, Rows(homography), Rows(fundamental));
  }

  // In a row; the pairs 1 2 and 2 3 have twice the matches of 3 4.
  void AddFourPhotos() {
    for (const double x : {-1.2, 0.0, 1.2, 2.4}) AddPhoto({x, -3, 3});
    Match(1, 2, 1, 2);
    Match(2, 3, 1, 2);
    Match(3, 4, 1, 4);
  }

  StatusOr<std::optional<InitialPair>> Choose(
      const std::vector<InitialPair>& in_vain = {}) {
    writer_.reset();
    FREEGS_ASSIGN_OR_RETURN(const MatchDatabase database,
                            MatchDatabase::Open(path_));
    return ChooseInitialPair(photos_, in_vain, database);
  }

  StatusOr<std::vector<InitialPair>> Best(size_t count) {
    writer_.reset();
    return BestPairs(photos_, count, path_);
  }

  // With a fake COLMAP, from the best pair or from the last of `pairs`. Returns
  // how many photos each model has.
  StatusOr<std::vector<size_t>> Map(
      const std::vector<std::pair<std::string, std::string>>& settings,
      const std::vector<InitialPair>& pairs = {},
      const MapperOptions& mapper_options = {}) {
    writer_.reset();
    SfmInput input;
    input.photo_folder = folder_.path();
    input.work_folder = folder_.path();
    input.photos = photos_;
    int mappings = 0;
    input.progress = [&](const Progress& progress) {
      if (progress.done == 0 && ++mappings == crash_in_) {
        folder_.Write("crash", "");
      }
    };
    SfmOptions options;
    options.colmap = MakeFakeColmap(folder_.path(), settings);
    FREEGS_ASSIGN_OR_RETURN(ColmapProgram colmap,
                            ColmapProgram::Find(options.colmap, nullptr));
    const StepContext context{input, options, colmap};
    fs::create_directories(folder_ / "logs");
    const fs::path mapper = folder_ / "mapper";
    FREEGS_ASSIGN_OR_RETURN(
        const std::vector<Reconstruction> models,
        pairs.empty()
            ? MapFromBestPair(context, path_, mapper, mapper_options)
            : MapFromLastPair(context, path_, mapper, pairs, mapper_options));
    std::vector<size_t> sizes;
    for (const Reconstruction& model : models) {
      sizes.push_back(model.images.size());
    }
    return sizes;
  }

  // With these settings the mapper crashes in its run `number`, from 1.
  std::vector<std::pair<std::string, std::string>> CrashIn(int number) {
    crash_in_ = number;
    return {{"FAKE_COLMAP_PAIR", "10"},
            {"FAKE_COLMAP_FAIL", "mapper"},
            {"FAKE_COLMAP_SIGNAL", std::to_string(SIGABRT)},
            {"FAKE_COLMAP_ONCE", (folder_ / "crash").string()}};
  }

  std::string Log() const { return ReadText(folder_ / "logs" / "mapper.log"); }

 private:
  static std::vector<double> Rows(const Eigen::Matrix3d& matrix) {
    std::vector<double> values;
    for (int i = 0; i < 9; ++i) values.push_back(matrix(i / 3, i % 3));
    return values;
  }

  TemporaryFolder folder_;
  fs::path path_ = folder_ / "a.db";
  std::unique_ptr<MatchDatabaseWriter> writer_ =
      std::make_unique<MatchDatabaseWriter>(path_);
  std::vector<Eigen::Vector3d> points_ = MakePoints();
  std::vector<SfmPhoto> photos_;
  std::vector<Rigid3d> poses_;
  int crash_in_ = 0;
};

TEST_F(ChooseInitialPairTest, WideAndNotOnAPlane) {
  AddPhoto({0, -3, 3});
  AddPhoto({0.02, -3, 3});  // Nearly where the first one is.
  AddPhoto({1.2, -3, 3});
  AddPhoto({2.4, -2.5, 3});
  Match(1, 2, 0, 1);
  Match(1, 3, 1, 2);  // Half of the matches, none of them on the plane.
  Match(2, 4, 0, 2);  // Half of them, all on the plane.
  Match(3, 4, 1, 5);
  const auto pair = Choose();
  ASSERT_TRUE(pair.ok()) << pair.status().message();
  ASSERT_TRUE(*pair);
  EXPECT_EQ((*pair)->id1, 1u);
  EXPECT_EQ((*pair)->id2, 3u);
  EXPECT_EQ((*pair)->matches, kNumPoints / 2);
  EXPECT_GT((*pair)->angle_deg, 10);
}

TEST_F(ChooseInitialPairTest, InTheLargestGroup) {
  AddPhoto({0, -3, 3});
  AddPhoto({1.2, -3, 3});
  AddPhoto({-1.2, -3, 3});
  AddPhoto({2.4, -2.5, 3});
  AddPhoto({3, -2, 3});
  Match(1, 2, 0, 1);  // The best pair, but of two photos alone.
  Match(3, 4, 1, 4);
  Match(4, 5, 1, 4);
  const auto pair = Choose();
  ASSERT_TRUE(pair.ok()) << pair.status().message();
  ASSERT_TRUE(*pair);
  EXPECT_EQ((*pair)->id1, 3u);
  EXPECT_EQ((*pair)->id2, 4u);
}

TEST_F(ChooseInitialPairTest, NoPhotoThatWasTriedInVain) {
  AddFourPhotos();
  const auto pair = Choose({{1, 2}});
  ASSERT_TRUE(pair.ok()) << pair.status().message();
  ASSERT_TRUE(*pair);
  EXPECT_EQ((*pair)->id1, 3u);
  EXPECT_EQ((*pair)->id2, 4u);
}

TEST_F(ChooseInitialPairTest, BestPairsShareNoPhoto) {
  AddFourPhotos();
  const auto pairs = Best(3);
  ASSERT_TRUE(pairs.ok()) << pairs.status().message();
  ASSERT_EQ(pairs->size(), 2u);
  EXPECT_EQ((*pairs)[0].id1, 1u);
  EXPECT_EQ((*pairs)[1].id1, 3u);
  EXPECT_EQ(Best(1)->size(), 1u);
}

TEST_F(ChooseInitialPairTest, NothingToBeginWith) {
  AddPhoto({0, -3, 3});
  AddPhoto({0.02, -3, 3});  // An angle of 0.3 degrees.
  AddPhoto({0, -2, 2});     // Straight ahead.
  AddPhoto({1.2, -3, 3});   // Few matches.
  Match(1, 2, 0, 1);
  Match(1, 3, 0, 1);
  Match(1, 4, 0, 8);
  const auto pair = Choose();
  ASSERT_TRUE(pair.ok()) << pair.status().message();
  EXPECT_FALSE(*pair);
}

TEST_F(ChooseInitialPairTest, MappingBeginsThere) {
  for (const double x : {0.0, 1.2, 2.4}) AddPhoto({x, -3, 3});
  Match(1, 2, 0, 4);
  Match(2, 3, 1, 2);
  const auto models =
      Map({{"FAKE_COLMAP_PAIR", "3"}, {"FAKE_COLMAP_MODELS", "2,1"}});
  ASSERT_TRUE(models.ok()) << models.status().message();
  EXPECT_THAT(*models, testing::ElementsAre(3));
  EXPECT_THAT(Log(), testing::HasSubstr("image pair #2 and #3"));
}

// The best pair is passed over. An option that is given to COLMAP twice would
// make it fail.
TEST_F(ChooseInitialPairTest, MappingBeginsWithALaterPair) {
  AddFourPhotos();
  const auto pairs = Best(2);
  ASSERT_TRUE(pairs.ok()) << pairs.status().message();
  const auto models =
      Map({{"FAKE_COLMAP_PAIR", "4"}}, *pairs, {.relaxed = true});
  ASSERT_TRUE(models.ok()) << models.status().message();
  EXPECT_THAT(*models, testing::ElementsAre(4));
  EXPECT_THAT(Log(), testing::HasSubstr("image pair #3 and #4"));
}

TEST_F(ChooseInitialPairTest, NoModelWhereALaterPairLeadsNowhere) {
  AddFourPhotos();
  const auto pairs = Best(2);
  ASSERT_TRUE(pairs.ok()) << pairs.status().message();
  const auto models =
      Map({{"FAKE_COLMAP_PAIR", ""}, {"FAKE_COLMAP_MODELS", "2,1"}}, *pairs);
  ASSERT_TRUE(models.ok()) << models.status().message();
  EXPECT_THAT(*models, testing::IsEmpty());
}

TEST_F(ChooseInitialPairTest, ColmapLooksForAPairWhereThatLeadsNowhere) {
  for (const double x : {0.0, 1.2, 2.4}) AddPhoto({x, -3, 3});
  Match(1, 2, 0, 4);
  Match(2, 3, 1, 2);
  const auto models =
      Map({{"FAKE_COLMAP_PAIR", ""}, {"FAKE_COLMAP_MODELS", "2,1"}});
  ASSERT_TRUE(models.ok()) << models.status().message();
  EXPECT_THAT(*models, testing::ElementsAre(2, 1));
}

// The fake takes the first photos whatever the pair is, so that a second model
// is all of the first one again.
TEST_F(ChooseInitialPairTest, ModelsWithoutTheirPairDoNotGoOnForever) {
  for (int i = 0; i < 22; ++i) AddPhoto({0.6 * i, -3, 3});
  for (int i = 1; i < 22; ++i) Match(i, i + 1, 1, 2);
  const auto models = Map({{"FAKE_COLMAP_PAIR", "10"}});
  ASSERT_TRUE(models.ok()) << models.status().message();
  EXPECT_THAT(*models, testing::ElementsAre(10));
}

TEST_F(ChooseInitialPairTest, ACrashKeepsTheModelsThatAreThere) {
  for (int i = 0; i < 22; ++i) AddPhoto({0.6 * i, -3, 3});
  for (int i = 1; i < 22; ++i) Match(i, i + 1, 1, 2);
  const auto models = Map(CrashIn(2));
  ASSERT_TRUE(models.ok()) << models.status().message();
  EXPECT_THAT(*models, testing::ElementsAre(10));
  // Without any, another run may have more luck.
  EXPECT_EQ(Map(CrashIn(1)).status().code(), StatusCode::kInternal);
}

TEST_F(ChooseInitialPairTest, ColmapLooksForAPairWhereThereIsNone) {
  for (const double x : {0.0, 1.2, 2.4}) AddPhoto({x, -3, 3});
  const auto models =
      Map({{"FAKE_COLMAP_PAIR", "3"}, {"FAKE_COLMAP_MODELS", "2"}});
  ASSERT_TRUE(models.ok()) << models.status().message();
  EXPECT_THAT(*models, testing::ElementsAre(2));
}

}  // namespace
}  // namespace freegs::sfm
