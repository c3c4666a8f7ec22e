// SPDX-License-Identifier: BSD-3-Clause
// Each kind of finding on a scene made to have it, and not on others.

#include "sfm/diagnosis/diagnosis.h"

#include <cmath>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sfm/diagnosis/photo_reasons.h"
#include "sfm/mapping/health.h"
#include "tests/sfm/synthetic_model.h"

namespace freegs::sfm {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

// Photos 0 to count - 1, each of which matches the next two.
SceneEvidence Chain(int count) {
  SceneEvidence evidence;
  for (int i = 0; i < count; ++i) {
    PhotoEvidence photo;
    photo.name = PhotoName(i);
    photo.width = 640;
    photo.height = 480;
    photo.num_features = 1500;
    photo.sharpness = 300 + i;
    photo.feature_scale = 0.003;
    evidence.photos.push_back(photo);
  }
  for (size_t i = 0; i + 1 < evidence.photos.size(); ++i) {
    evidence.pairs.push_back({i, i + 1, 300, false, {}});
    if (i + 2 < evidence.photos.size()) {
      evidence.pairs.push_back({i, i + 2, 100, false, {}});
    }
  }
  return evidence;
}

// A model of the first `count` of `total` photos.
std::vector<Reconstruction> ModelOf(int count, int total, int points = 200) {
  Reconstruction model = SyntheticModel(total, points);
  model.images.resize(count);
  RemoveDanglingReferences(&model);
  return {model};
}

void DropPairsBetween(SceneEvidence* evidence, size_t border) {
  std::erase_if(evidence->pairs, [border](const PairEvidence& pair) {
    return (pair.first < border) != (pair.second < border);
  });
}

std::vector<FindingKind> Kinds(const std::vector<Finding>& findings) {
  std::vector<FindingKind> kinds;
  for (const Finding& finding : findings) {
    kinds.push_back(finding.kind);
    EXPECT_FALSE(finding.message.empty());
    EXPECT_FALSE(finding.advice.empty());
    EXPECT_FALSE(finding.evidence.empty());
  }
  return kinds;
}

Eigen::Matrix3d Intrinsics(double focal) {
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Identity();
  matrix(0, 0) = matrix(1, 1) = focal;
  matrix(0, 2) = 320;
  matrix(1, 2) = 240;
  return matrix;
}

// The homography of a plane at distance 1 before the first camera, after a
// turn about y and a step to the side.
Eigen::Matrix3d Homography(double angle, double step) {
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitY()).toRotationMatrix();
  const Eigen::Matrix3d motion =
      turn + Eigen::Vector3d(step, 0, 0) * Eigen::RowVector3d(0, 0, 1);
  return 3.7 * (Intrinsics(560) * motion * Intrinsics(560).inverse());
}

TEST(Diagnose, NothingWrongWithAGoodScene) {
  const auto findings = Diagnose(Chain(12), ModelOf(12, 12), {});
  EXPECT_THAT(findings, IsEmpty());
  EXPECT_THAT(ExplainUnregistered(Chain(12), ModelOf(12, 12), {}), IsEmpty());
}

TEST(Diagnose, EmptyInput) {
  EXPECT_THAT(Kinds(Diagnose({}, {}, {})),
              ElementsAre(FindingKind::kTooFewPhotos));
}

TEST(Diagnose, TooFewPhotos) {
  const auto two = Diagnose(Chain(2), {}, {});
  EXPECT_THAT(Kinds(two), testing::Contains(FindingKind::kTooFewPhotos));
  EXPECT_EQ(two[0].severity, Severity::kFatal);
  EXPECT_TRUE(two[0].hopeless);
  const auto five = Diagnose(Chain(5), ModelOf(5, 5), {});
  EXPECT_THAT(Kinds(five), ElementsAre(FindingKind::kTooFewPhotos));
  EXPECT_EQ(five[0].severity, Severity::kDegrading);
  EXPECT_THAT(five[0].message, HasSubstr("only 5 photos"));
}

TEST(Diagnose, TooLittleTexture) {
  SceneEvidence evidence = Chain(12);
  for (PhotoEvidence& photo : evidence.photos) photo.num_features = 40;
  evidence.pairs.clear();
  const auto findings = Diagnose(evidence, {}, {});
  EXPECT_THAT(Kinds(findings), ElementsAre(FindingKind::kTooLittleTexture));
  EXPECT_FALSE(findings[0].hopeless);
  EXPECT_EQ(findings[0].evidence[0].second, 40);
  // Two photos only: they are named.
  evidence = Chain(12);
  DropPairsBetween(&evidence, 10);
  evidence.photos[10].num_features = evidence.photos[11].num_features = 9;
  const auto some = Diagnose(evidence, ModelOf(10, 12), {});
  EXPECT_THAT(Kinds(some), ElementsAre(FindingKind::kTooLittleTexture));
  EXPECT_THAT(some[0].photos, ElementsAre(PhotoName(10), PhotoName(11)));
  // With a good model, few features were enough.
  for (PhotoEvidence& photo : evidence.photos) photo.num_features = 40;
  EXPECT_THAT(Diagnose(Chain(12), ModelOf(12, 12), {}), IsEmpty());
}

TEST(Diagnose, BlurredPhotosAreNamed) {
  SceneEvidence evidence = Chain(12);
  DropPairsBetween(&evidence, 10);
  for (size_t i : {10, 11}) {
    evidence.photos[i].sharpness = 4;
    evidence.photos[i].num_features = 30;
  }
  const auto findings = Diagnose(evidence, ModelOf(10, 12), {});
  EXPECT_THAT(Kinds(findings), ElementsAre(FindingKind::kBlurred));
  EXPECT_THAT(findings[0].photos, ElementsAre(PhotoName(10), PhotoName(11)));
  const auto reasons = ExplainUnregistered(evidence, ModelOf(10, 12), {});
  ASSERT_EQ(reasons.size(), 2u);
  EXPECT_THAT(reasons.at(PhotoName(10)), HasSubstr("blurred"));
  // A blurred photo that was registered all the same does no harm.
  EXPECT_THAT(Diagnose(evidence, ModelOf(12, 12), {}), IsEmpty());
}

TEST(Diagnose, AllPhotosBlurred) {
  SceneEvidence evidence = Chain(12);
  for (PhotoEvidence& photo : evidence.photos) photo.feature_scale = 0.015;
  EXPECT_THAT(Kinds(Diagnose(evidence, {}, {})),
              ElementsAre(FindingKind::kBlurred));
  // Also when they could be registered somehow.
  EXPECT_THAT(Kinds(Diagnose(evidence, ModelOf(12, 12), {})),
              ElementsAre(FindingKind::kBlurred));
}

TEST(Diagnose, ModelOfFewPoints) {
  // What bare walls gave.
  const auto findings = Diagnose(Chain(12), ModelOf(12, 12, 58), {});
  EXPECT_THAT(Kinds(findings), ElementsAre(FindingKind::kTooLittleTexture));
  EXPECT_EQ(findings[0].severity, Severity::kFatal);
  EXPECT_THAT(findings[0].message, HasSubstr("a photo sees 58"));
  EXPECT_THAT(Diagnose(Chain(12), ModelOf(12, 12, 100), {}), IsEmpty());
}

TEST(Diagnose, TurningOnTheSpot) {
  SceneEvidence evidence = Chain(12);
  for (size_t i = 0; i < evidence.pairs.size(); ++i) {
    PairEvidence& pair = evidence.pairs[i];
    pair.is_homography = true;
    pair.homography = Homography(0.1 + 0.02 * static_cast<double>(i), 0);
  }
  const TurningOnTheSpot turning = MeasureTurning(evidence);
  EXPECT_EQ(turning.homography_share, 1);
  EXPECT_NEAR(turning.stretch, 1, 0.05);
  // Whatever a mapper made of some of them, or with a wrong lens of all.
  for (const auto& models :
       {std::vector<Reconstruction>(), ModelOf(9, 12), ModelOf(12, 12)}) {
    const auto findings = Diagnose(evidence, models, {});
    ASSERT_FALSE(findings.empty());
    EXPECT_EQ(findings[0].kind, FindingKind::kNoBaseline);
    EXPECT_EQ(findings[0].severity, Severity::kFatal);
    EXPECT_TRUE(findings[0].hopeless);
  }
}

// Cameras in a row, a step apart, that see all points at a distance of 1.
std::vector<Reconstruction> RowOfCameras(int count, double step) {
  std::vector<Reconstruction> models = ModelOf(count, count);
  Reconstruction& model = models[0];
  for (Point3D& point : model.points3d) point.xyz = {0.4, 0, 1};
  for (size_t i = 0; i < model.images.size(); ++i) {
    PosedImage& image = model.images[i];
    image.cam_from_world.rotation.setIdentity();
    image.cam_from_world.translation = {-step * static_cast<double>(i), 0, 0};
    const auto pixel =
        Project(model.cameras[0], image.cam_from_world * model.points3d[0].xyz);
    for (Point2D& feature : image.points2d) feature.xy = pixel.value();
  }
  return models;
}

// Neighbours of a film are nearly the same: homographies explain all pairs, and
// hardly differ from rotations. The model must claim no more than they show.
TEST(Diagnose, AFilmOfSmallStepsIsNotTurning) {
  const double step = 0.06;
  SceneEvidence evidence = Chain(12);
  for (PairEvidence& pair : evidence.pairs) {
    pair.is_homography = true;
    pair.homography = Homography(0, step);
  }
  const TurningOnTheSpot turning = MeasureTurning(evidence);
  EXPECT_TRUE(turning.certain());
  const auto right = RowOfCameras(12, step);
  EXPECT_GT(ShownParallax(evidence, right[0], turning.focal), 0.5);
  EXPECT_THAT(Diagnose(evidence, right, {}), IsEmpty());
  // Steps three times as wide would show.
  const auto wide = RowOfCameras(12, 3 * step);
  EXPECT_LT(ShownParallax(evidence, wide[0], turning.focal), 0.35);
  EXPECT_THAT(Kinds(Diagnose(evidence, wide, {})),
              ElementsAre(FindingKind::kNoBaseline));
  EXPECT_EQ(ShownParallax(evidence, {}, turning.focal), 0);
}

TEST(Diagnose, PlanarSceneIsNotTurning) {
  SceneEvidence evidence = Chain(12);
  for (size_t i = 0; i < evidence.pairs.size(); ++i) {
    PairEvidence& pair = evidence.pairs[i];
    pair.is_homography = true;
    pair.homography = Homography(0.05, 0.3 + 0.02 * static_cast<double>(i));
  }
  EXPECT_GT(MeasureTurning(evidence).stretch, 1.1);
  const auto findings = Diagnose(evidence, {}, {});
  EXPECT_THAT(Kinds(findings), ElementsAre(FindingKind::kPlanarScene));
  EXPECT_FALSE(findings[0].hopeless);
  EXPECT_THAT(Diagnose(evidence, ModelOf(12, 12), {}), IsEmpty());
}

TEST(Diagnose, SidewaysAlongAWallIsNotTurning) {
  // Homographies with all eigenvalues 1, as small rotations nearly have.
  SceneEvidence evidence = Chain(12);
  for (PairEvidence& pair : evidence.pairs) {
    pair.is_homography = true;
    pair.homography = Homography(0, 0.5);
  }
  EXPECT_FALSE(MeasureTurning(evidence).certain());
}

TEST(Diagnose, TwoScenesAreNamed) {
  SceneEvidence evidence = Chain(14);
  DropPairsBetween(&evidence, 10);
  evidence.pairs.push_back({3, 12, kMinLink - 1, false, {}});  // By chance.
  const auto findings = Diagnose(evidence, ModelOf(10, 14), {});
  EXPECT_THAT(Kinds(findings), ElementsAre(FindingKind::kSeparateScenes));
  EXPECT_THAT(
      findings[0].photos,
      ElementsAre(PhotoName(10), PhotoName(11), PhotoName(12), PhotoName(13)));
  EXPECT_EQ(findings[0].severity, Severity::kDegrading);
  const auto reasons = ExplainUnregistered(evidence, ModelOf(10, 14), {});
  EXPECT_THAT(reasons.at(PhotoName(11)), HasSubstr("another scene"));
  // A model that holds both parts proves them connected.
  EXPECT_THAT(Diagnose(evidence, ModelOf(14, 14), {}), IsEmpty());
}

TEST(Diagnose, NoOverlap) {
  SceneEvidence evidence = Chain(12);
  evidence.pairs.clear();
  const auto all = Diagnose(evidence, {}, {});
  EXPECT_THAT(Kinds(all), ElementsAre(FindingKind::kNoOverlap));
  EXPECT_THAT(all[0].message, HasSubstr("of 12 photos"));
  evidence = Chain(12);
  DropPairsBetween(&evidence, 11);
  const auto one = Diagnose(evidence, ModelOf(11, 12), {});
  EXPECT_THAT(Kinds(one), ElementsAre(FindingKind::kNoOverlap));
  EXPECT_THAT(one[0].photos, ElementsAre(PhotoName(11)));
}

TEST(Diagnose, UnplacedPhotosAreNamed) {
  SceneEvidence evidence = Chain(12);
  evidence.unplaced = {PhotoName(10), PhotoName(11)};
  const auto found = Diagnose(evidence, ModelOf(10, 12), {});
  ASSERT_THAT(Kinds(found), testing::Contains(FindingKind::kLookAlikes));
  for (const Finding& finding : found) {
    if (finding.kind != FindingKind::kLookAlikes) continue;
    EXPECT_EQ(finding.severity, Severity::kDegrading);
    EXPECT_THAT(finding.photos, ElementsAre(PhotoName(10), PhotoName(11)));
    EXPECT_THAT(finding.message, HasSubstr(PhotoName(11)));
  }
}

TEST(Diagnose, UncertainPhotosAreNamed) {
  SceneEvidence evidence = Chain(12);
  evidence.uncertain = {PhotoName(11)};
  const auto models = ModelOf(11, 12);
  const auto found = Diagnose(evidence, models, {});
  ASSERT_THAT(Kinds(found), ElementsAre(FindingKind::kUncertainPoses));
  EXPECT_EQ(found[0].severity, Severity::kDegrading);
  EXPECT_EQ(found[0].photos, evidence.uncertain);
  EXPECT_THAT(found[0].message, HasSubstr(PhotoName(11) + " belongs"));
  EXPECT_THAT(ExplainUnregistered(evidence, models, {}).at(PhotoName(11)),
              HasSubstr("left out"));
}

TEST(GroupByMatches, MainGroupFirst) {
  SceneEvidence evidence = Chain(12);
  DropPairsBetween(&evidence, 8);
  // The smaller part has the model: it is the main one.
  Reconstruction model = SyntheticModel(12, 20);
  model.images.erase(model.images.begin(), model.images.begin() + 8);
  const PhotoGroups groups = GroupByMatches(evidence, {model});
  ASSERT_EQ(groups.members.size(), 2u);
  EXPECT_THAT(groups.members[0], ElementsAre(8, 9, 10, 11));
  EXPECT_EQ(groups.group[0], 1);
  EXPECT_EQ(GroupByMatches(evidence, {}).members[0].size(), 8u);
}

// What becomes of findings and models: the table of verdicts.
TEST(Verdict, FollowsFromTheWorstFindingAndTheShareOfPhotos) {
  const auto finding = [](Severity severity) {
    Finding result;
    result.severity = severity;
    result.message = "something was seen";
    result.advice = "do something";
    return result;
  };
  std::vector<std::string> names;
  for (int i = 0; i < 10; ++i) names.push_back(PhotoName(i));
  struct Case {
    int registered;
    std::vector<Severity> findings;
    Verdict verdict;
  };
  for (const Case& test : std::vector<Case>{
           {10, {}, Verdict::kOk},
           {10, {Severity::kDegrading}, Verdict::kDegraded},
           {10, {Severity::kFatal}, Verdict::kFailed},
           {9, {}, Verdict::kOk},
           {8, {}, Verdict::kDegraded},
           {8, {Severity::kDegrading}, Verdict::kDegraded},
           {8, {Severity::kFatal, Severity::kDegrading}, Verdict::kFailed},
           {4, {}, Verdict::kFailed},
           {0, {Severity::kDegrading}, Verdict::kFailed},
       }) {
    std::vector<Finding> findings;
    for (const Severity severity : test.findings) {
      findings.push_back(finding(severity));
    }
    const auto models = test.registered > 0 ? ModelOf(test.registered, 10)
                                            : std::vector<Reconstruction>();
    const Health health = MeasureHealth(models, names, true, {}, {}, findings);
    EXPECT_EQ(health.verdict, test.verdict) << test.registered;
    EXPECT_EQ(health.reason.empty(), test.verdict == Verdict::kOk);
    if (test.verdict == Verdict::kOk) continue;
    EXPECT_FALSE(health.advice.empty());
    if (findings.empty()) continue;
    EXPECT_THAT(health.reason, HasSubstr("something was seen"));
    EXPECT_THAT(health.advice, HasSubstr("do something"));
  }
}

TEST(Verdict, FindingsAndAttemptsAreWritten) {
  Health health;
  health.findings = Diagnose(Chain(2), {}, {});
  Attempt attempt;
  attempt.name = "mapping";
  attempt.problem = "none";
  health.attempts.push_back(attempt);
  const nlohmann::json json = HealthToJson(health);
  EXPECT_EQ(json["findings"][0]["kind"], "too_few_photos");
  EXPECT_EQ(json["findings"][0]["severity"], "fatal");
  EXPECT_EQ(json["findings"][0]["evidence"]["photos"], 2);
  EXPECT_EQ(json["attempts"][0]["name"], "mapping");
  for (const char* key : {"why",
                          "registered",
                          "models",
                          "points",
                          "mean_reprojection_error_px",
                          "kept",
                          "problem"}) {
    EXPECT_TRUE(json["attempts"][0].contains(key)) << key;
  }
}

}  // namespace
}  // namespace freegs::sfm
