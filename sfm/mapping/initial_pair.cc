// SPDX-License-Identifier: BSD-3-Clause

#include "sfm/mapping/initial_pair.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <unordered_map>
#include <utility>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "core/decompositions.h"
#include "core/quantile.h"
#include "sfm/diagnosis/evidence.h"
#include "sfm/scene/two_views.h"

namespace freegs::sfm {
namespace {

using Models = std::vector<Reconstruction>;

// COLMAP drops points whose rays meet at less.
constexpr double kMinAngleDeg = 1.5;

// COLMAP places a photo if so many points of the model fit.
constexpr int64_t kMinMatches = 30;

// COLMAP does not begin with a pair that goes more straight ahead.
constexpr double kMaxForward = 0.95;

// Where the camera moved little, COLMAP may misjudge the motion between the two
// photos, and then no other photo fits. This is seen at once.
constexpr size_t kMaxTrials = 3;

// The features of a photo, and its guessed pinhole camera.
struct Photo {
  std::vector<Eigen::Vector2f> features;
  Eigen::Matrix3d intrinsics = Eigen::Matrix3d::Identity();
};

Eigen::Matrix3d GuessIntrinsics(const SfmPhoto& photo) {
  Eigen::Matrix3d intrinsics = Eigen::Matrix3d::Identity();
  intrinsics(0, 0) = intrinsics(1, 1) =
      photo.focal_px > 0 ? photo.focal_px : GuessedFocal(photo);
  intrinsics(0, 2) = photo.width / 2.0;
  intrinsics(1, 2) = photo.height / 2.0;
  return intrinsics;
}

// Where the matches of a pair lie: column i of both is match i, (x, y, 1).
struct MatchedPixels {
  Eigen::Matrix3Xd pixels1;
  Eigen::Matrix3Xd pixels2;
};

MatchedPixels PixelsOf(const Photo& photo1,
                       const Photo& photo2,
                       std::span<const FeatureMatch> matches) {
  MatchedPixels result{Eigen::Matrix3Xd(3, matches.size()),
                       Eigen::Matrix3Xd(3, matches.size())};
  Eigen::Index count = 0;
  for (const FeatureMatch& match : matches) {
    if (match.feature1 >= photo1.features.size() ||
        match.feature2 >= photo2.features.size()) {
      continue;
    }
    result.pixels1.col(count) =
        photo1.features[match.feature1].cast<double>().homogeneous();
    result.pixels2.col(count) =
        photo2.features[match.feature2].cast<double>().homogeneous();
    ++count;
  }
  result.pixels1.conservativeResize(3, count);
  result.pixels2.conservativeResize(3, count);
  return result;
}

// For a rotation R and a direction t of the way, with ray2 ~ R ray1 + t: the
// matches that lie in front of both cameras, each as the angle between its
// rays, for t and for -t.
struct InFront {
  std::vector<double> angles_deg;
  std::vector<double> angles_deg_reversed;
};

InFront FindInFront(const Eigen::Matrix3d& rotation,
                    const Eigen::Vector3d& t,
                    const Eigen::Matrix3Xd& rays1,
                    const Eigen::Matrix3Xd& rays2) {
  InFront result;
  for (Eigen::Index i = 0; i < rays1.cols(); ++i) {
    const Eigen::Vector3d turned = rotation * rays1.col(i);
    const Eigen::Vector3d ray2 = rays2.col(i);
    const RayDepths depths = FindRayDepths(turned, ray2, t);
    if (!(depths.depth1 * depths.depth2 > 0)) continue;
    (depths.depth1 > 0 ? result.angles_deg : result.angles_deg_reversed)
        .push_back(RayAngleDeg(turned, ray2));
  }
  return result;
}

// How good it is to begin with a pair; a score of 0 means not at all.
struct Rating {
  double score = 0;
  PairMotion motion;
};

Rating Rate(const Photo& photo1,
            const Photo& photo2,
            const MatchDatabase::VerifiedPair& pair,
            std::span<const FeatureMatch> matches) {
  if (!pair.fundamental) return {};
  const MatchedPixels seen = PixelsOf(photo1, photo2, matches);
  if (seen.pixels1.cols() < kMinMatches) return {};
  const Eigen::Matrix3d& k1 = photo1.intrinsics;
  const Eigen::Matrix3d& k2 = photo2.intrinsics;
  Rating rating;
  rating.motion = MeasureMotion(k2.transpose() * *pair.fundamental * k1,
                                k1.inverse() * seen.pixels1,
                                k2.inverse() * seen.pixels2);
  if (rating.motion.in_front < kMinMatches ||
      rating.motion.forward > kMaxForward ||
      rating.motion.angle_deg < kMinAngleDeg) {
    return {};
  }
  const double relief = pair.homography
                            ? 1 - ShareExplained(*pair.homography,
                                                 seen.pixels1.topRows<2>(),
                                                 seen.pixels2.topRows<2>())
                            : 1;
  rating.score = static_cast<double>(rating.motion.in_front) *
                 std::min(rating.motion.angle_deg, kUsualStartAngleDeg) *
                 relief;
  return rating;
}

using PhotosById = std::unordered_map<uint32_t, Photo>;

// Returns the photos that are in the largest group.
StatusOr<PhotosById> ReadLargestGroup(const std::vector<SfmPhoto>& photos,
                                      const MatchDatabase& database) {
  FREEGS_ASSIGN_OR_RETURN(const SceneEvidence evidence,
                          CollectEvidence(photos, database));
  const PhotoGroups groups = GroupByMatches(evidence, {});
  FREEGS_ASSIGN_OR_RETURN(const auto ids, database.PhotoIds());
  PhotosById by_id;
  for (size_t i = 0; i < photos.size(); ++i) {
    const auto id = ids.find(photos[i].name);
    if (groups.group[i] != 0 || id == ids.end()) continue;
    Photo& made = by_id[id->second];
    made.intrinsics = GuessIntrinsics(photos[i]);
    FREEGS_ASSIGN_OR_RETURN(made.features,
                            database.FeaturePositions(id->second));
  }
  return by_id;
}

std::set<std::string> NamesOf(const Reconstruction& model) {
  std::set<std::string> names;
  for (const PosedImage& image : model.images) names.insert(image.name);
  return names;
}

// Drops models of which all photos are in the first one, too.
void DropPartsOfFirst(Models* models) {
  const std::set<std::string> first = NamesOf(models->front());
  const auto is_part = [&](const Reconstruction& model) {
    return std::all_of(
        model.images.begin(), model.images.end(), [&](const auto& image) {
          return first.contains(image.name);
        });
  };
  models->erase(std::remove_if(models->begin() + 1, models->end(), is_part),
                models->end());
}

}  // namespace

PairMotion MeasureMotion(const Eigen::Matrix3d& essential,
                         const Eigen::Matrix3Xd& rays1,
                         const Eigen::Matrix3Xd& rays2) {
  const SingularValues3 svd = DecomposeSingular(essential);
  const Eigen::Vector3d direction = svd.u.col(2);
  Eigen::Matrix3d quarter_turn;
  quarter_turn << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  PairMotion best;
  for (const Eigen::Matrix3d& turn :
       {quarter_turn, Eigen::Matrix3d(quarter_turn.transpose())}) {
    Eigen::Matrix3d rotation = svd.u * turn * svd.v.transpose();
    if (rotation.determinant() < 0) rotation = -rotation;
    InFront found = FindInFront(rotation, direction, rays1, rays2);
    for (std::vector<double>* angles :
         {&found.angles_deg, &found.angles_deg_reversed}) {
      const auto count = static_cast<int64_t>(angles->size());
      if (count <= best.in_front) continue;
      best = {count, UpperMedian(std::move(*angles)), std::abs(direction.z())};
    }
  }
  return best;
}

StatusOr<std::optional<InitialPair>> ChooseInitialPair(
    const std::vector<SfmPhoto>& photos,
    std::span<const InitialPair> in_vain,
    const MatchDatabase& database) {
  FREEGS_ASSIGN_OR_RETURN(PhotosById by_id, ReadLargestGroup(photos, database));
  for (const InitialPair& pair : in_vain) {
    by_id.erase(pair.id1);
    by_id.erase(pair.id2);
  }
  FREEGS_ASSIGN_OR_RETURN(const auto pairs, database.VerifiedPairs());
  std::map<std::pair<uint32_t, uint32_t>, const MatchDatabase::VerifiedPair*>
      geometry;
  for (const MatchDatabase::VerifiedPair& pair : pairs) {
    geometry[{pair.id1, pair.id2}] = &pair;
  }
  std::optional<InitialPair> best;
  double best_score = 0;
  FREEGS_RETURN_IF_ERROR(database.ForEachVerifiedPair(
      [&](uint32_t id1, uint32_t id2, std::span<const FeatureMatch> matches) {
        const auto pair = geometry.find({id1, id2});
        const auto photo1 = by_id.find(id1);
        const auto photo2 = by_id.find(id2);
        if (pair == geometry.end() || photo1 == by_id.end() ||
            photo2 == by_id.end()) {
          return;
        }
        const Rating rating =
            Rate(photo1->second, photo2->second, *pair->second, matches);
        if (rating.score <= best_score) return;
        best_score = rating.score;
        best = InitialPair{
            id1, id2, rating.motion.in_front, rating.motion.angle_deg};
      }));
  return best;
}

StatusOr<std::vector<InitialPair>> BestPairs(
    const std::vector<SfmPhoto>& photos,
    size_t count,
    const std::filesystem::path& database) {
  FREEGS_ASSIGN_OR_RETURN(const MatchDatabase matches,
                          MatchDatabase::Open(database));
  std::vector<InitialPair> pairs;
  while (pairs.size() < count) {
    FREEGS_ASSIGN_OR_RETURN(const std::optional<InitialPair> pair,
                            ChooseInitialPair(photos, pairs, matches));
    if (!pair) break;
    pairs.push_back(*pair);
  }
  return pairs;
}

StatusOr<std::vector<Reconstruction>> MapFromLastPair(
    const StepContext& context,
    const std::filesystem::path& database,
    const std::filesystem::path& folder,
    std::vector<InitialPair> pairs,
    const MapperOptions& options) {
  Models models;
  if (pairs.empty()) return models;
  std::vector<SfmPhoto> left = context.input.photos;
  const size_t enough = std::min(kUsualMinModel, (left.size() + 1) / 2);
  std::vector<InitialPair> passed_over = std::move(pairs);  // Or tried in vain.
  MapperOptions from_pair = options;
  from_pair.pair = passed_over.back();
  passed_over.pop_back();
  const size_t most_passed_over = passed_over.size() + kMaxTrials;
  while (from_pair.pair) {
    from_pair.further = options.further || !models.empty();
    StatusOr<Models> mapped = MapPhotos(context, database, folder, from_pair);
    // The models that there are do not need this one.
    if (mapped.status().code() == StatusCode::kUnusableResult &&
        !models.empty()) {
      mapped = Models();
    }
    FREEGS_ASSIGN_OR_RETURN(Models made, std::move(mapped));
    size_t placed = 0;
    if (NumRegistered(made) >= enough) {
      const std::set<std::string> names = NamesOf(made[0]);
      placed = std::erase_if(left, [&](const SfmPhoto& photo) {
        return names.contains(photo.name);
      });
    }
    if (placed > 0) {
      models.push_back(std::move(made[0]));
    } else {  // COLMAP may drop the pair itself at the end.
      passed_over.push_back(*from_pair.pair);
    }
    if (passed_over.size() == most_passed_over ||
        (!models.empty() && left.size() < kUsualMinModel)) {
      break;
    }
    FREEGS_ASSIGN_OR_RETURN(const MatchDatabase matches,
                            MatchDatabase::Open(database));
    FREEGS_ASSIGN_OR_RETURN(from_pair.pair,
                            ChooseInitialPair(left, passed_over, matches));
  }
  if (models.empty()) return models;
  SortBySize(&models);
  DropPartsOfFirst(&models);
  return models;
}

StatusOr<std::vector<Reconstruction>> MapFromBestPair(
    const StepContext& context,
    const std::filesystem::path& database,
    const std::filesystem::path& folder,
    const MapperOptions& options) {
  FREEGS_ASSIGN_OR_RETURN(const std::vector<InitialPair> pairs,
                          BestPairs(context.input.photos, 1, database));
  FREEGS_ASSIGN_OR_RETURN(
      Models models,
      MapFromLastPair(context, database, folder, pairs, options));
  if (models.empty()) return MapPhotos(context, database, folder, options);
  return models;
}

}  // namespace freegs::sfm
