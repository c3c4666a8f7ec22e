// SPDX-License-Identifier: BSD-3-Clause

#include "sfm/mapping/known_poses.h"

#include <algorithm>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <unordered_map>
#include <utility>

#include "core/number_text.h"
#include "core/text.h"
#include "sfm/features/point_colors.h"
#include "sfm/mapping/scene_database.h"
#include "sfm/matching/match_database.h"

namespace freegs::sfm {
namespace {

constexpr double kMinFittingShare = 0.5;

// The share for one photo. In 44 drawn scenes with true poses (docs/sfm.md) the
// least was 0.47, but for three photos that match each other only.
constexpr double kMinPhotoShare = 0.25;

// So few matches of a photo tell nothing about its pose.
constexpr int64_t kMinPhotoMatches = 30;

// The photos that have a pose, with their cameras, so that matches are verified
// with these.
SfmInput WithCameras(const SfmInput& input, const Reconstruction& poses) {
  std::map<uint32_t, const Camera*> cameras;
  for (const Camera& camera : poses.cameras) cameras[camera.id] = &camera;
  std::map<std::string, const Camera*> camera_of;
  for (const PosedImage& image : poses.images) {
    camera_of[image.name] = cameras.at(image.camera_id);
  }
  SfmInput result = input;
  result.photos.clear();
  for (SfmPhoto photo : input.photos) {
    const auto camera = camera_of.find(photo.name);
    if (camera == camera_of.end()) continue;
    photo.camera = *camera->second;
    result.photos.push_back(std::move(photo));
  }
  return result;
}

// Returns the model without features and points, and with the ids of the
// database, in which each photo has a camera of its own. New releases of COLMAP
// refuse a model whose cameras are not those of the database.
StatusOr<Reconstruction> PosesOf(const Reconstruction& model,
                                 const std::filesystem::path& path) {
  FREEGS_ASSIGN_OR_RETURN(const MatchDatabase database,
                          MatchDatabase::Open(path));
  FREEGS_ASSIGN_OR_RETURN(const auto ids, database.PhotoIds());
  FREEGS_ASSIGN_OR_RETURN(const auto camera_ids, database.CameraIds());
  const auto camera_index = IndexCameras(model);
  Reconstruction poses;
  for (const PosedImage& image : model.images) {
    const auto id = ids.find(image.name);
    if (id == ids.end()) continue;
    PosedImage bare;
    bare.id = id->second;
    bare.camera_id = camera_ids.at(image.name);
    poses.cameras.push_back(model.cameras[camera_index.at(image.camera_id)]);
    poses.cameras.back().id = bare.camera_id;
    bare.name = image.name;
    bare.cam_from_world = image.cam_from_world;
    poses.images.push_back(std::move(bare));
  }
  return poses;
}

// Gives the images the cameras that those of the same name have in `model`.
void TakeCameras(const Reconstruction& model, Reconstruction* result) {
  std::map<std::string, uint32_t> camera_of;
  for (const PosedImage& image : model.images) {
    camera_of[image.name] = image.camera_id;
  }
  for (PosedImage& image : result->images) {
    image.camera_id = camera_of.at(image.name);
  }
  result->cameras = model.cameras;
}

// The verified matches of all pairs, and how many of them have two features
// that see the same point.
StatusOr<std::vector<PairFit>> FitOfPairs(const Reconstruction& model,
                                          const std::filesystem::path& path) {
  FREEGS_ASSIGN_OR_RETURN(const MatchDatabase database,
                          MatchDatabase::Open(path));
  std::unordered_map<uint32_t, const PosedImage*> images;
  for (const PosedImage& image : model.images) images[image.id] = &image;
  const auto point_of = [&](uint32_t id, uint32_t feature) {
    const auto image = images.find(id);
    return image == images.end() || feature >= image->second->points2d.size()
               ? kNoPoint3D
               : image->second->points2d[feature].point3d_id;
  };
  std::vector<PairFit> pairs;
  FREEGS_RETURN_IF_ERROR(database.ForEachVerifiedPair(
      [&](uint32_t id1, uint32_t id2, std::span<const FeatureMatch> matches) {
        PairFit pair{id1, id2, static_cast<int64_t>(matches.size()), 0};
        for (const FeatureMatch& match : matches) {
          const uint64_t point = point_of(id1, match.feature1);
          if (point != kNoPoint3D && point == point_of(id2, match.feature2)) {
            ++pair.fitting;
          }
        }
        pairs.push_back(pair);
      }));
  return pairs;
}

// Nothing if there are no matches.
std::optional<double> FittingShare(std::span<const PairFit> pairs) {
  int64_t matched = 0;
  int64_t fitting = 0;
  for (const PairFit& pair : pairs) {
    matched += pair.matched;
    fitting += pair.fitting;
  }
  if (matched == 0) return std::nullopt;
  return static_cast<double>(fitting) / static_cast<double>(matched);
}

// `photos`: of which the shares are; empty if of all.
Finding UnfitPoses(double fitting_share, std::vector<std::string> photos) {
  const double limit = photos.empty() ? kMinFittingShare : kMinPhotoShare;
  Finding finding;
  finding.kind = FindingKind::kUnfitPoses;
  finding.severity = Severity::kDegrading;
  finding.evidence = {{"fitting_share", fitting_share},
                      {"min_fitting_share", limit}};
  finding.message =
      photos.empty()
          ? "of the matches between photos only a share of " +
                FormatFixed(fitting_share, 2) + " fits the imported poses"
          : SomeNames(photos) + ": at most a share of " +
                FormatFixed(fitting_share, 2) +
                " of the matches with other photos fits the imported poses";
  finding.advice =
      photos.empty()
          ? "check that the poses belong to these photos, and the axes and "
            "intrinsics of the file, or let structure from motion find the "
            "poses (without sfm.import)"
          : "check that these poses belong to these photos, or leave them out "
            "of the file";
  finding.photos = std::move(photos);
  return finding;
}

// The finding about single photos, if there are any.
std::optional<Finding> UnfitPhotos(std::span<const PairFit> pairs,
                                   const Reconstruction& model) {
  const std::map<uint32_t, double> shares = PhotosThatDoNotFit(pairs);
  if (shares.empty()) return std::nullopt;
  std::vector<std::string> names;
  double largest = 0;
  for (const PosedImage& image : model.images) {
    const auto share = shares.find(image.id);
    if (share == shares.end()) continue;
    names.push_back(image.name);
    largest = std::max(largest, share->second);
  }
  std::ranges::sort(names);
  return UnfitPoses(largest, std::move(names));
}

}  // namespace

std::map<uint32_t, double> PhotosThatDoNotFit(std::span<const PairFit> pairs) {
  // Two photos in wrong places may both be all that the other one matches, so
  // what is suspected is judged by its matches with all others.
  std::map<uint32_t, double> suspects;
  for (int round = 0; round < 2; ++round) {
    std::map<uint32_t, PairFit> of_photo;
    for (const PairFit& pair : pairs) {
      for (const auto& [id, other] :
           {std::pair(pair.id1, pair.id2), {pair.id2, pair.id1}}) {
        if (suspects.contains(other)) continue;
        of_photo[id].matched += pair.matched;
        of_photo[id].fitting += pair.fitting;
      }
    }
    const std::map<uint32_t, double> before = std::move(suspects);
    suspects.clear();
    for (const auto& [id, sum] : of_photo) {
      const double share =
          static_cast<double>(sum.fitting) / static_cast<double>(sum.matched);
      if (round > 0 && !before.contains(id)) continue;
      if (sum.matched < kMinPhotoMatches || share >= kMinPhotoShare) continue;
      suspects[id] = share;
    }
  }
  return suspects;
}

StatusOr<TriangulatedScene> TriangulateScene(const SfmInput& input,
                                             const SfmOptions& options,
                                             const Reconstruction& poses) {
  const SfmInput posed = WithCameras(input, poses);
  SfmOptions with_own_cameras = options;
  with_own_cameras.camera = "per_image";
  FREEGS_ASSIGN_OR_RETURN(const std::unique_ptr<SceneDatabase> scene,
                          SceneDatabase::Build(posed, with_own_cameras));
  const StepContext& context = scene->context();
  TriangulatedScene result;
  result.colmap_version = context.colmap.version();
  result.warnings = context.colmap.KnownFaults();
  result.pairs = scene->record().pairs();
  result.image_size = context.options.max_image_size;
  result.max_features = context.options.max_features;
  FREEGS_ASSIGN_OR_RETURN(const Reconstruction bare,
                          PosesOf(poses, scene->path()));
  FREEGS_ASSIGN_OR_RETURN(
      result.model,
      TriangulatePoints(
          context, scene->path(), input.work_folder / "triangulation", bare));
  TakeCameras(poses, &result.model);
  FREEGS_ASSIGN_OR_RETURN(const std::vector<PairFit> pairs,
                          FitOfPairs(result.model, scene->path()));
  result.fitting_share = FittingShare(pairs);
  if (result.fitting_share && *result.fitting_share < kMinFittingShare) {
    result.findings.push_back(UnfitPoses(*result.fitting_share, {}));
  } else if (auto finding = UnfitPhotos(pairs, result.model)) {
    result.findings.push_back(std::move(*finding));
  }
  FREEGS_RETURN_IF_ERROR(
      ColorPoints(posed, context.num_threads, &result.model));
  return result;
}

}  // namespace freegs::sfm
