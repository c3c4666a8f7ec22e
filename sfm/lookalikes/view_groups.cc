// SPDX-License-Identifier: BSD-3-Clause
// Measures the evidence between photos and joins them in groups.

#include "sfm/lookalikes/view_groups.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <span>
#include <unordered_map>

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

// With less evidence than this against them, two groups hold together, whatever
// supports them.
constexpr double kMinAgainst = 30;
constexpr size_t kMinPhotos = 4;

using Pair = std::pair<uint32_t, uint32_t>;

// The point (x, y, 1) in the camera frame that is seen at a pixel, by Newton's
// method; for the pixels of features, which lie inside the image.
Eigen::Vector3d Unproject(const Camera& camera, const Eigen::Vector2d& pixel) {
  constexpr double kStep = 1e-6;
  Eigen::Vector3d ray((pixel.x() - camera.PrincipalX()) / camera.FocalX(),
                      (pixel.y() - camera.PrincipalY()) / camera.FocalY(),
                      1);
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
    if (!step.allFinite() || step.norm() > 1) break;
    ray.head<2>() += step;
  }
  return ray;
}

struct GroupedPhoto {
  const PosedImage* image = nullptr;
  double focal = 0;
  std::vector<Eigen::Vector3d> rays;  // Of the features.
};

// Counts matches that fit two photos' poses.
int64_t CountFitting(const GroupedPhoto& photo1,
                     const GroupedPhoto& photo2,
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

struct Evidence {
  double supporting = 0;
  double against = 0;

  void Add(const Evidence& other) {
    supporting += other.supporting;
    against += other.against;
  }
  double surplus() const {
    return (1 - kMinSupport) * supporting - kMinSupport * against;
  }
  double share() const { return supporting / (supporting + against); }
  bool HoldsTogether() const { return surplus() > 0 || against < kMinAgainst; }
  bool IsStronger(const Evidence& other) const {
    return std::pair(HoldsTogether(), surplus()) >
           std::pair(other.HoldsTogether(), other.surplus());
  }
};

// Groups of photos, by the least id of each, and the evidence between them.
class Contraction {
 public:
  explicit Contraction(const std::vector<PairSupport>& pairs) {
    for (const PairSupport& pair : pairs) {
      members_[pair.image_id1] = {pair.image_id1};
      members_[pair.image_id2] = {pair.image_id2};
      Connect(pair.image_id1, pair.image_id2, {pair.supporting, pair.against});
    }
  }

  // Two groups, and the evidence between them.
  struct Link {
    uint32_t a = 0;  // Smaller than b.
    uint32_t b = 0;
    Evidence evidence;
  };
  // Finds the two groups with the largest surplus of support. False if no two
  // groups have any evidence between them.
  bool Strongest(Link* strongest) const {
    bool any = false;
    for (const auto& [a, neighbours] : links_) {
      for (auto it = neighbours.upper_bound(a); it != neighbours.end(); ++it) {
        if (!any || it->second.IsStronger(strongest->evidence)) {
          *strongest = {a, it->first, it->second};
          any = true;
        }
      }
    }
    return any;
  }

  void Join(uint32_t a, uint32_t b) {
    auto& joined = members_[a];
    joined.insert(members_[b].begin(), members_[b].end());
    members_.erase(b);
    const auto neighbours = std::move(links_[b]);
    links_.erase(b);
    for (const auto& [other, evidence] : neighbours) {
      links_[other].erase(b);
      if (other != a) Connect(a, other, evidence);
    }
  }

  const std::map<uint32_t, std::set<uint32_t>>& members() const {
    return members_;
  }

 private:
  void Connect(uint32_t a, uint32_t b, const Evidence& evidence) {
    links_[a][b].Add(evidence);
    links_[b][a].Add(evidence);
  }

  std::map<uint32_t, std::set<uint32_t>> members_;
  std::map<uint32_t, std::map<uint32_t, Evidence>> links_;
};

}  // namespace

StatusOr<std::vector<PairSupport>> MeasureSupport(
    const Reconstruction& model, const MatchDatabase& database) {
  const auto camera_index = IndexCameras(model);
  std::unordered_map<uint32_t, GroupedPhoto> photos;
  for (const PosedImage& image : model.images) {
    const Camera& camera = model.cameras[camera_index.at(image.camera_id)];
    GroupedPhoto& photo = photos[image.id];
    photo.image = &image;
    photo.focal = std::sqrt(camera.FocalX() * camera.FocalY());
    photo.rays.reserve(image.points2d.size());
    for (const Point2D& feature : image.points2d) {
      photo.rays.push_back(Unproject(camera, feature.xy));
    }
  }
  FREEGS_ASSIGN_OR_RETURN(const auto verified, database.VerifiedPairs());
  std::map<Pair, const MatchDatabase::VerifiedPair*> verified_of;
  for (const MatchDatabase::VerifiedPair& pair : verified) {
    verified_of[{pair.id1, pair.id2}] = &pair;
  }
  std::map<Pair, Evidence> evidence;
  std::set<Pair> fits;
  FREEGS_RETURN_IF_ERROR(database.ForEachVerifiedPair(
      [&](uint32_t id1, uint32_t id2, std::span<const FeatureMatch> matches) {
        const auto photo1 = photos.find(id1);
        const auto photo2 = photos.find(id2);
        if (photo1 == photos.end() || photo2 == photos.end()) return;
        const auto fitting = static_cast<double>(
            CountFitting(photo1->second, photo2->second, matches));
        const auto count = static_cast<double>(matches.size());
        const double weight = MatchWeight(*verified_of.at({id1, id2}),
                                          *photo1->second.image,
                                          *photo2->second.image,
                                          matches);
        const double doubt = std::clamp(
            (kFitShare - fitting / count) / (kFitShare - kMisfitShare),
            0.0,
            1.0);
        const bool fit = 2 * fitting > count;
        if (fit) fits.insert({id1, id2});
        evidence[{id1, id2}].Add(
            {fit ? weight * fitting : 0, weight * doubt * (count - fitting)});
      }));
  FREEGS_ASSIGN_OR_RETURN(const auto compared, database.ComparedPairs());
  for (const SharedView& view : FindMissingCorrespondences(model, compared)) {
    evidence[{view.image_id1, view.image_id2}].Add(
        {0, kMissingWeight * view.missing});
  }
  std::vector<PairSupport> pairs;
  for (const auto& [ids, between] : evidence) {
    pairs.push_back({ids.first,
                     ids.second,
                     between.supporting,
                     fits.contains(ids),
                     between.against});
  }
  return pairs;
}

ViewGroups FindViewGroups(const Reconstruction& model,
                          const std::vector<PairSupport>& pairs) {
  ViewGroups result;
  std::set<uint32_t> unseen;
  for (const PosedImage& image : model.images) unseen.insert(image.id);
  if (unseen.size() < kMinPhotos) {
    result.groups.emplace_back(unseen.begin(), unseen.end());
    return result;
  }
  Contraction contraction(pairs);
  Contraction::Link link;
  bool held = true;
  // The groups are final as soon as nothing holds two of them together. Joining
  // goes on all the same, because the score is the least share met on the way.
  while (contraction.Strongest(&link)) {
    if (held && !link.evidence.HoldsTogether()) {
      held = false;
      for (const auto& [leader, members] : contraction.members()) {
        result.groups.emplace_back(members.begin(), members.end());
      }
    }
    if (link.evidence.against >= kMinAgainst) {
      result.score = std::min(result.score, link.evidence.share());
    }
    contraction.Join(link.a, link.b);
  }
  if (held) {
    for (const auto& [leader, members] : contraction.members()) {
      result.groups.emplace_back(members.begin(), members.end());
    }
    // Groups without any evidence between them do not speak against the model.
    for (size_t g = 1; g < result.groups.size(); ++g) {
      result.groups[0].insert(result.groups[0].end(),
                              result.groups[g].begin(),
                              result.groups[g].end());
    }
    if (!result.groups.empty()) result.groups.resize(1);
  }
  std::stable_sort(
      result.groups.begin(),
      result.groups.end(),
      [](const auto& a, const auto& b) { return a.size() > b.size(); });
  if (result.groups.empty()) result.groups.emplace_back();
  std::map<uint32_t, size_t> group;
  for (size_t g = 0; g < result.groups.size(); ++g) {
    for (const uint32_t id : result.groups[g]) {
      group[id] = g;
      unseen.erase(id);
    }
  }
  result.groups[0].insert(result.groups[0].end(), unseen.begin(), unseen.end());
  std::sort(result.groups[0].begin(), result.groups[0].end());
  for (const PairSupport& pair : pairs) {
    if (group[pair.image_id1] != group[pair.image_id2] && pair.fits) {
      result.suspects.emplace_back(pair.image_id1, pair.image_id2);
    }
  }
  return result;
}

StatusOr<ViewGroups> GroupViews(const Reconstruction& model,
                                const std::filesystem::path& path) {
  FREEGS_ASSIGN_OR_RETURN(const MatchDatabase database,
                          MatchDatabase::Open(path));
  FREEGS_ASSIGN_OR_RETURN(const std::vector<PairSupport> pairs,
                          MeasureSupport(model, database));
  return FindViewGroups(model, pairs);
}

Reconstruction RestrictTo(const Reconstruction& model,
                          const std::vector<uint32_t>& image_ids) {
  const std::set<uint32_t> kept(image_ids.begin(), image_ids.end());
  Reconstruction part;
  std::set<uint32_t> cameras;
  for (const PosedImage& image : model.images) {
    if (!kept.contains(image.id)) continue;
    part.images.push_back(image);
    cameras.insert(image.camera_id);
  }
  for (const Camera& camera : model.cameras) {
    if (cameras.contains(camera.id)) part.cameras.push_back(camera);
  }
  for (const Point3D& point : model.points3d) {
    Point3D seen = point;
    std::erase_if(seen.track, [&](const TrackElement& element) {
      return !kept.contains(element.image_id);
    });
    std::set<uint32_t> observers;
    for (const TrackElement& e : seen.track) observers.insert(e.image_id);
    if (observers.size() >= 2) part.points3d.push_back(std::move(seen));
  }
  RemoveDanglingReferences(&part);
  return part;
}

}  // namespace freegs::sfm
