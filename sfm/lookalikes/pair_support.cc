// SPDX-License-Identifier: BSD-3-Clause

#include "sfm/lookalikes/pair_support.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <span>
#include <unordered_map>
#include <utility>

#include <Eigen/LU>

#include "sfm/lookalikes/missing_correspondences.h"
#include "sfm/scene/two_views.h"

namespace freegs::sfm {
namespace {

constexpr double kMaxErrorPx = 4;
constexpr double kMissingWeight = 0.5;

// The matches of a pair count in full if a homography explains at most
// kReliefShare of them, and only kPlanarWeight if it explains kPlanarShare or
// more.
constexpr double kReliefShare = 0.6;
constexpr double kPlanarShare = 0.8;
constexpr double kPlanarWeight = 0.2;

// If at most the first share of a pair's matches fits, the others count in full
// against the model; from the second share on they do not count at all.
constexpr double kMisfitShare = 0.1;
constexpr double kFitShare = 0.3;

using Pair = std::pair<uint32_t, uint32_t>;

// The point (x, y, 1) in the camera frame that is seen at a pixel, by Newton's
// method; for the pixels of features, which lie inside the image.
Eigen::Vector3d Unproject(const Camera& camera, const Eigen::Vector2d& pixel) {
  constexpr double kStep = 1e-6;
  constexpr double kMaxFisheyeAngle = 1.5;
  Eigen::Vector3d ray((pixel.x() - camera.PrincipalX()) / camera.FocalX(),
                      (pixel.y() - camera.PrincipalY()) / camera.FocalY(),
                      1);
  if (GetCameraModel(camera.model).fisheye) {
    // Without distortion the distance from the principal point is the angle.
    const double angle = std::min(ray.head<2>().norm(), kMaxFisheyeAngle);
    if (angle > 0) ray.head<2>() *= std::tan(angle) / ray.head<2>().norm();
  }
  for (int round = 0; round < 10; ++round) {
    const auto here = Project(camera, ray);
    const auto right = Project(camera, ray + kStep * Eigen::Vector3d::UnitX());
    const auto down = Project(camera, ray + kStep * Eigen::Vector3d::UnitY());
    if (!here || !right || !down) break;
    const Eigen::Vector2d error = pixel - *here;
    if (error.squaredNorm() < 1e-6) break;
    Eigen::Matrix2d jacobian;
    jacobian.col(0) = (*right - *here) / kStep;
    jacobian.col(1) = (*down - *here) / kStep;
    const Eigen::Vector2d step = jacobian.inverse() * error;
    const double longest = std::max(1.0, ray.head<2>().norm());
    if (!step.allFinite() || step.norm() > longest) break;
    ray.head<2>() += step;
  }
  return ray;
}

struct PosedPhoto {
  const PosedImage* image = nullptr;
  double focal = 0;
  std::vector<Eigen::Vector3d> rays;  // Rays of the features.
};

// Counts matches that fit two photos' poses.
int64_t CountFitting(const PosedPhoto& photo1,
                     const PosedPhoto& photo2,
                     std::span<const FeatureMatch> matches) {
  const Rigid3d motion =
      photo2.image->cam_from_world * Inverse(photo1.image->cam_from_world);
  const Eigen::Matrix3d rotation = motion.rotation.toRotationMatrix();
  const Eigen::Vector3d& t = motion.translation;
  Eigen::Matrix3d cross;
  cross << 0, -t.z(), t.y(), t.z(), 0, -t.x(), -t.y(), t.x(), 0;
  const Eigen::Matrix3d essential = cross * rotation;
  const double limit = kMaxErrorPx / std::sqrt(photo1.focal * photo2.focal);
  int64_t fitting = 0;
  for (const FeatureMatch& match : matches) {
    if (match.feature1 >= photo1.rays.size() ||
        match.feature2 >= photo2.rays.size()) {
      continue;
    }
    const Eigen::Vector3d& ray1 = photo1.rays[match.feature1];
    const Eigen::Vector3d& ray2 = photo2.rays[match.feature2];
    const Eigen::Vector3d line2 = essential * ray1;
    const Eigen::Vector3d line1 = essential.transpose() * ray2;
    const double norm = std::sqrt(line1.head<2>().squaredNorm() +
                                  line2.head<2>().squaredNorm());
    if (!(std::abs(ray2.dot(line2)) < limit * norm)) continue;
    const RayDepths depths = FindRayDepths(rotation * ray1, ray2, t);
    if (depths.depth1 > 0 && depths.depth2 > 0) ++fitting;
  }
  return fitting;
}

// How much each of a pair's matches counts.
double MatchWeight(const MatchDatabase::VerifiedPair& pair,
                   const PosedImage& image1,
                   const PosedImage& image2,
                   std::span<const FeatureMatch> matches) {
  if (!pair.homography) return pair.is_homography ? kPlanarWeight : 1.0;
  Eigen::Matrix2Xd pixels1(2, matches.size());
  Eigen::Matrix2Xd pixels2(2, matches.size());
  Eigen::Index count = 0;
  for (const FeatureMatch& match : matches) {
    if (match.feature1 >= image1.points2d.size() ||
        match.feature2 >= image2.points2d.size()) {
      continue;
    }
    pixels1.col(count) = image1.points2d[match.feature1].xy;
    pixels2.col(count) = image2.points2d[match.feature2].xy;
    ++count;
  }
  const double share = ShareExplained(
      *pair.homography, pixels1.leftCols(count), pixels2.leftCols(count));
  const double relief = std::clamp(
      (kPlanarShare - share) / (kPlanarShare - kReliefShare), 0.0, 1.0);
  return kPlanarWeight + (1 - kPlanarWeight) * relief;
}

// What the verified matches of a pair say.
PairSupport SupportOf(const PosedPhoto& photo1,
                      const PosedPhoto& photo2,
                      const MatchDatabase::VerifiedPair& pair,
                      std::span<const FeatureMatch> matches) {
  const auto count = static_cast<double>(matches.size());
  const auto fitting =
      static_cast<double>(CountFitting(photo1, photo2, matches));
  const double weight =
      MatchWeight(pair, *photo1.image, *photo2.image, matches);
  const double doubt = std::clamp(
      (kFitShare - fitting / count) / (kFitShare - kMisfitShare), 0.0, 1.0);
  PairSupport support;
  support.fits = 2 * fitting > count;
  support.supporting = support.fits ? weight * fitting : 0;
  support.against = weight * doubt * (count - fitting);
  return support;
}

std::unordered_map<uint32_t, PosedPhoto> PhotosOf(const Reconstruction& model) {
  const auto camera_index = IndexCameras(model);
  std::unordered_map<uint32_t, PosedPhoto> photos;
  for (const PosedImage& image : model.images) {
    const Camera& camera = model.cameras[camera_index.at(image.camera_id)];
    PosedPhoto& photo = photos[image.id];
    photo.image = &image;
    photo.focal = std::sqrt(camera.FocalX() * camera.FocalY());
    photo.rays.reserve(image.points2d.size());
    for (const Point2D& feature : image.points2d) {
      photo.rays.push_back(Unproject(camera, feature.xy));
    }
  }
  return photos;
}

}  // namespace

StatusOr<std::vector<PairSupport>> MeasureSupport(
    const Reconstruction& model, const MatchDatabase& database) {
  const auto photos = PhotosOf(model);
  FREEGS_ASSIGN_OR_RETURN(const auto verified, database.VerifiedPairs());
  std::map<Pair, const MatchDatabase::VerifiedPair*> verified_of;
  for (const MatchDatabase::VerifiedPair& pair : verified) {
    verified_of[{pair.id1, pair.id2}] = &pair;
  }
  std::map<Pair, PairSupport> support_of;
  FREEGS_RETURN_IF_ERROR(database.ForEachVerifiedPair(
      [&](uint32_t id1, uint32_t id2, std::span<const FeatureMatch> matches) {
        const auto photo1 = photos.find(id1);
        const auto photo2 = photos.find(id2);
        if (photo1 == photos.end() || photo2 == photos.end()) return;
        support_of[{id1, id2}] = SupportOf(photo1->second,
                                           photo2->second,
                                           *verified_of.at({id1, id2}),
                                           matches);
      }));
  FREEGS_ASSIGN_OR_RETURN(const auto compared, database.ComparedPairs());
  for (const SharedView& view : FindMissingCorrespondences(model, compared)) {
    support_of[{view.image_id1, view.image_id2}].against +=
        kMissingWeight * view.missing;
  }
  std::vector<PairSupport> pairs;
  for (auto& [ids, support] : support_of) {
    support.image_id1 = ids.first;
    support.image_id2 = ids.second;
    pairs.push_back(support);
  }
  return pairs;
}

}  // namespace freegs::sfm
