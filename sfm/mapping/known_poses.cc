// SPDX-License-Identifier: BSD-3-Clause

#include "sfm/mapping/known_poses.h"

#include <map>
#include <memory>
#include <span>
#include <unordered_map>
#include <utility>

#include "core/number_text.h"
#include "sfm/features/point_colors.h"
#include "sfm/mapping/scene_database.h"
#include "sfm/matching/match_database.h"

namespace freegs::sfm {
namespace {

constexpr double kMinFittingShare = 0.5;

// The photos that have a pose, with the focal lengths of their cameras, so that
// matches are verified with these.
SfmInput WithFocals(const SfmInput& input, const Reconstruction& poses) {
  std::map<uint32_t, const Camera*> cameras;
  for (const Camera& camera : poses.cameras) cameras[camera.id] = &camera;
  std::map<std::string, double> focals;
  for (const PosedImage& image : poses.images) {
    focals[image.name] = cameras.at(image.camera_id)->FocalX();
  }
  SfmInput result = input;
  result.photos.clear();
  for (SfmPhoto photo : input.photos) {
    const auto focal = focals.find(photo.name);
    if (focal == focals.end()) continue;
    photo.focal_px = focal->second;
    result.photos.push_back(std::move(photo));
  }
  return result;
}

// Without features and points, and with the ids of the database.
StatusOr<Reconstruction> PosesOf(const Reconstruction& model,
                                 const std::filesystem::path& path) {
  FREEGS_ASSIGN_OR_RETURN(const MatchDatabase database,
                          MatchDatabase::Open(path));
  FREEGS_ASSIGN_OR_RETURN(const auto ids, database.PhotoIds());
  Reconstruction poses;
  poses.cameras = model.cameras;
  for (const PosedImage& image : model.images) {
    const auto id = ids.find(image.name);
    if (id == ids.end()) continue;
    PosedImage bare;
    bare.id = id->second;
    bare.camera_id = image.camera_id;
    bare.name = image.name;
    bare.cam_from_world = image.cam_from_world;
    poses.images.push_back(std::move(bare));
  }
  return poses;
}

// Of the verified matches, the share whose two features see the same point.
StatusOr<double> FittingShare(const Reconstruction& model,
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
  int64_t matched = 0;
  int64_t fitting = 0;
  FREEGS_RETURN_IF_ERROR(database.ForEachVerifiedPair(
      [&](uint32_t id1, uint32_t id2, std::span<const FeatureMatch> matches) {
        for (const FeatureMatch& match : matches) {
          const uint64_t point = point_of(id1, match.feature1);
          ++matched;
          if (point != kNoPoint3D && point == point_of(id2, match.feature2)) {
            ++fitting;
          }
        }
      }));
  return matched == 0
             ? 0.0
             : static_cast<double>(fitting) / static_cast<double>(matched);
}

Finding UnfitPoses(double fitting_share) {
  Finding finding;
  finding.kind = FindingKind::kUnfitPoses;
  finding.severity = Severity::kDegrading;
  finding.evidence = {{"fitting_share", fitting_share},
                      {"min_fitting_share", kMinFittingShare}};
  finding.message = "of the matches between photos only a share of " +
                    FormatFixed(fitting_share, 2) + " fits the imported poses";
  finding.advice =
      "check that the poses belong to these photos, and the axes and "
      "intrinsics of the file, or let structure from motion find the poses "
      "(without sfm.import)";
  return finding;
}

}  // namespace

StatusOr<TriangulatedScene> TriangulateScene(const SfmInput& input,
                                             const SfmOptions& options,
                                             const Reconstruction& poses) {
  const SfmInput posed = WithFocals(input, poses);
  FREEGS_ASSIGN_OR_RETURN(const std::unique_ptr<SceneDatabase> scene,
                          SceneDatabase::Build(posed, options));
  const StepContext& context = scene->context();
  TriangulatedScene result;
  result.colmap_version = context.colmap.version();
  result.warnings = context.colmap.KnownFaults();
  result.pairs = scene->record().pairs();
  result.image_size = context.options.max_image_size;
  result.max_features = context.options.max_features;
  context.Report("points", 0, 1, "");
  FREEGS_ASSIGN_OR_RETURN(const Reconstruction bare,
                          PosesOf(poses, scene->path()));
  FREEGS_ASSIGN_OR_RETURN(
      result.model,
      TriangulatePoints(
          context, scene->path(), input.work_folder / "triangulation", bare));
  FREEGS_ASSIGN_OR_RETURN(result.fitting_share,
                          FittingShare(result.model, scene->path()));
  if (result.fitting_share < kMinFittingShare) {
    result.findings.push_back(UnfitPoses(result.fitting_share));
  }
  FREEGS_RETURN_IF_ERROR(
      ColorPoints(posed, context.num_threads, &result.model));
  context.Report("points", 1, 1, "");
  return result;
}

}  // namespace freegs::sfm
