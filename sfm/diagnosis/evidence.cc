// SPDX-License-Identifier: BSD-3-Clause
// Collects evidence from COLMAP's database.

#include "sfm/diagnosis/evidence.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <unordered_map>

#include <Eigen/LU>

#include "core/decompositions.h"
#include "core/disjoint_sets.h"
#include "core/quantile.h"
#include "sfm/scene/reconstruction_measures.h"
#include "sfm/scene/sfm_photo.h"

namespace freegs::sfm {
namespace {

// The ratio of the largest to the smallest singular value of inv(K2) H K1, for
// a focal length given as a share of the photo's longest side.
double Stretch(const Eigen::Matrix3d& homography,
               const PhotoEvidence& from,
               const PhotoEvidence& to,
               double focal) {
  const auto intrinsics = [focal](const PhotoEvidence& photo) {
    const double f = focal * std::max(photo.width, photo.height);
    Eigen::Matrix3d matrix = Eigen::Matrix3d::Identity();
    matrix(0, 0) = matrix(1, 1) = f;
    matrix(0, 2) = photo.width / 2.0;
    matrix(1, 2) = photo.height / 2.0;
    return matrix;
  };
  const Eigen::Matrix3d normalised =
      intrinsics(to).inverse() * homography * intrinsics(from);
  const Eigen::Vector3d values = SingularValues(normalised);
  return values(2) > 0 ? values(0) / values(2) : 1e9;
}

// The median angle, in degrees, between the rays from two photos to the points
// that both see; 0 if these are few.
double MedianAngleDeg(
    const PosedImage& image1,
    const PosedImage& image2,
    const std::unordered_map<uint64_t, Eigen::Vector3d>& points) {
  constexpr size_t kMinPoints = 10;
  std::set<uint64_t> seen;
  for (const Point2D& feature : image1.points2d) {
    seen.insert(feature.point3d_id);
  }
  const std::vector<Eigen::Vector3d> centres = {
      CameraCentre(image1.cam_from_world), CameraCentre(image2.cam_from_world)};
  std::vector<double> angles;
  for (const Point2D& feature : image2.points2d) {
    const auto point = points.find(feature.point3d_id);
    if (point == points.end() || !seen.contains(feature.point3d_id)) continue;
    angles.push_back(TriangulationAngleDeg(point->second, centres));
  }
  return angles.size() < kMinPoints ? 0 : UpperMedian(std::move(angles));
}

}  // namespace

StatusOr<SceneEvidence> CollectEvidence(const std::vector<SfmPhoto>& photos,
                                        const MatchDatabase& database) {
  FREEGS_ASSIGN_OR_RETURN(const auto rows, database.Photos());
  FREEGS_ASSIGN_OR_RETURN(const auto pairs, database.VerifiedPairs());
  std::unordered_map<std::string, const MatchDatabase::Photo*> by_name;
  for (const MatchDatabase::Photo& row : rows) by_name[row.name] = &row;

  SceneEvidence evidence;
  std::unordered_map<uint32_t, size_t> index;
  for (const SfmPhoto& photo : photos) {
    PhotoEvidence seen;
    seen.name = photo.name;
    seen.width = photo.width;
    seen.height = photo.height;
    seen.sharpness = photo.sharpness;
    const auto row = by_name.find(photo.name);
    if (row != by_name.end()) {
      seen.num_features = row->second->num_features;
      index[row->second->id] = evidence.photos.size();
      // The scales only help to tell blur; the diagnosis works without them.
      const auto scales = database.FeatureScales(row->second->id);
      const int side = std::max(photo.width, photo.height);
      if (scales.ok() && side > 0) {
        seen.feature_scale =
            UpperMedian(std::vector<double>(scales->begin(), scales->end())) /
            side;
      }
    }
    evidence.photos.push_back(std::move(seen));
  }
  for (const MatchDatabase::VerifiedPair& pair : pairs) {
    const auto first = index.find(pair.id1);
    const auto second = index.find(pair.id2);
    if (first == index.end() || second == index.end()) continue;
    evidence.pairs.push_back(
        {first->second,
         second->second,
         pair.num_matches,
         pair.is_homography,
         pair.is_homography ? pair.homography : std::nullopt});
  }
  return evidence;
}

PhotoGroups GroupByMatches(const SceneEvidence& evidence,
                           const std::vector<Reconstruction>& models) {
  const size_t count = evidence.photos.size();
  std::unordered_map<std::string, size_t> place;
  for (size_t i = 0; i < count; ++i) place[evidence.photos[i].name] = i;

  PhotoGroups result;
  result.registered.assign(count, false);
  DisjointSets groups(count);
  for (const PairEvidence& pair : evidence.pairs) {
    if (pair.num_matches >= kMinLink) groups.Join(pair.first, pair.second);
  }
  std::optional<size_t> main;  // A photo of the main group.
  for (size_t k = 0; k < models.size(); ++k) {
    std::optional<size_t> leader;
    for (const PosedImage& image : models[k].images) {
      const auto it = place.find(image.name);
      if (it == place.end()) continue;
      if (!leader) leader = it->second;
      groups.Join(*leader, it->second);
      if (k == 0) result.registered[it->second] = true;
    }
    if (k == 0) main = leader;
  }

  std::map<size_t, std::vector<size_t>> members;
  for (size_t i = 0; i < count; ++i) members[groups.Find(i)].push_back(i);
  for (auto& [root, photos] : members) {
    result.members.push_back(std::move(photos));
  }
  const auto is_main = [&](const std::vector<size_t>& photos) {
    return main && groups.Find(photos[0]) == groups.Find(*main);
  };
  std::stable_sort(result.members.begin(),
                   result.members.end(),
                   [&](const auto& a, const auto& b) {
                     return std::pair(is_main(a), a.size()) >
                            std::pair(is_main(b), b.size());
                   });
  result.group.assign(count, 0);
  for (size_t g = 0; g < result.members.size(); ++g) {
    for (const size_t i : result.members[g]) {
      result.group[i] = static_cast<int>(g);
    }
  }
  return result;
}

TurningOnTheSpot MeasureTurning(const SceneEvidence& evidence) {
  TurningOnTheSpot result;
  int64_t homographies = 0;
  for (const PairEvidence& pair : evidence.pairs) {
    ++result.pairs;
    if (pair.is_homography) ++homographies;
  }
  if (result.pairs == 0) return result;
  result.homography_share =
      static_cast<double>(homographies) / static_cast<double>(result.pairs);
  // A sample, evenly spread, is enough for a median.
  constexpr size_t kMaxSample = 1000;
  std::vector<const PairEvidence*> sample;
  for (const PairEvidence& pair : evidence.pairs) {
    if (pair.homography) sample.push_back(&pair);
  }
  const size_t step = std::max<size_t>(1, sample.size() / kMaxSample);
  for (double focal = 0.5; focal < 1.65 && !sample.empty(); focal += 0.1) {
    std::vector<double> ratios;
    for (size_t i = 0; i < sample.size(); i += step) {
      ratios.push_back(Stretch(*sample[i]->homography,
                               evidence.photos[sample[i]->first],
                               evidence.photos[sample[i]->second],
                               focal));
    }
    const double median = UpperMedian(std::move(ratios));
    if (result.stretch == 0 || median < result.stretch) {
      result.stretch = median;
      result.focal = focal;
    }
  }
  return result;
}

double ShownParallax(const SceneEvidence& evidence,
                     const Reconstruction& model,
                     double focal) {
  std::unordered_map<std::string, const PosedImage*> images;
  for (const PosedImage& image : model.images) images[image.name] = &image;
  std::unordered_map<uint64_t, Eigen::Vector3d> points;
  for (const Point3D& point : model.points3d) points[point.id] = point.xyz;
  constexpr double kWideDeg = 60;  // Beyond, the tangent grows without end.
  std::vector<double> ratios;
  for (const PairEvidence& pair : evidence.pairs) {
    const PhotoEvidence& from = evidence.photos[pair.first];
    const PhotoEvidence& to = evidence.photos[pair.second];
    const auto first = images.find(from.name);
    const auto second = images.find(to.name);
    if (!pair.homography || first == images.end() || second == images.end()) {
      continue;
    }
    const double angle =
        MedianAngleDeg(*first->second, *second->second, points);
    if (!(angle > 0)) continue;
    const double stretch = Stretch(*pair.homography, from, to, focal);
    const double radians = std::min(angle, kWideDeg) * std::numbers::pi / 180;
    ratios.push_back((stretch - 1) / std::tan(radians));
  }
  return UpperMedian(std::move(ratios));
}

}  // namespace freegs::sfm
