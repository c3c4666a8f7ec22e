// SPDX-License-Identifier: BSD-3-Clause

#include "sfm/mapping/skeleton.h"

#include <algorithm>
#include <map>
#include <queue>
#include <set>
#include <string>
#include <utility>

#include "sfm/diagnosis/finding.h"
#include "sfm/mapping/initial_pair.h"

namespace freegs::sfm {
namespace {

namespace fs = std::filesystem;
using Models = std::vector<Reconstruction>;

// A skeleton of more photos saves too little.
constexpr double kMostOfThePhotos = 0.5;

// Fewer verified matches make no partners.
constexpr int64_t kPartnerMatches = 50;

// So many others count for each photo. Without this limit a few photos would be
// partners of all others where all photos show the same, and the skeleton would
// be too small.
constexpr size_t kMostPartners = 20;

// The partners of each photo, by its id.
using Partners = std::map<uint32_t, std::vector<uint32_t>>;

Partners FindPartners(std::span<const MatchDatabase::VerifiedPair> pairs) {
  // Most matches first, then smaller ids: pairs of the negative number of
  // matches and the id.
  std::map<uint32_t, std::vector<std::pair<int64_t, uint32_t>>> candidates;
  for (const MatchDatabase::VerifiedPair& pair : pairs) {
    if (pair.num_matches < kPartnerMatches) continue;
    candidates[pair.id1].emplace_back(-pair.num_matches, pair.id2);
    candidates[pair.id2].emplace_back(-pair.num_matches, pair.id1);
  }
  std::set<std::pair<uint32_t, uint32_t>> kept;
  for (auto& [id, others] : candidates) {
    std::sort(others.begin(), others.end());
    others.resize(std::min(others.size(), kMostPartners));
    for (const auto& [negative_matches, other] : others) {
      kept.insert(std::minmax(id, other));
    }
  }
  Partners partners;
  for (const auto& [id1, id2] : kept) {
    partners[id1].push_back(id2);
    partners[id2].push_back(id1);
  }
  return partners;
}

// The photos of the skeleton, in the order of the input; none if they are too
// many.
StatusOr<std::vector<SfmPhoto>> SkeletonPhotos(
    const std::vector<SfmPhoto>& photos, const fs::path& path) {
  FREEGS_ASSIGN_OR_RETURN(const MatchDatabase database,
                          MatchDatabase::Open(path));
  FREEGS_ASSIGN_OR_RETURN(const auto pairs, database.VerifiedPairs());
  FREEGS_ASSIGN_OR_RETURN(const auto ids, database.PhotoIds());
  const std::vector<uint32_t> chosen = ChooseSkeleton(pairs);
  const std::set<uint32_t> skeleton(chosen.begin(), chosen.end());
  std::vector<SfmPhoto> result;
  for (const SfmPhoto& photo : photos) {
    const auto id = ids.find(photo.name);
    if (id != ids.end() && skeleton.contains(id->second)) {
      result.push_back(photo);
    }
  }
  if (static_cast<double>(result.size()) >
      kMostOfThePhotos * static_cast<double>(photos.size())) {
    result.clear();
  }
  return result;
}

// The poses and cameras of a model without its features and points.
Reconstruction WithoutPoints(Reconstruction model) {
  model.points3d.clear();
  for (PosedImage& image : model.images) image.points2d.clear();
  return model;
}

// Photos that see no point of the model are left out.
Reconstruction WithoutBlindPhotos(const Reconstruction& model) {
  std::vector<uint32_t> ids;
  for (const PosedImage& image : model.images) {
    if (std::any_of(image.points2d.begin(),
                    image.points2d.end(),
                    [](const Point2D& point) {
                      return point.point3d_id != kNoPoint3D;
                    })) {
      ids.push_back(image.id);
    }
  }
  return RestrictTo(model, ids);
}

}  // namespace

std::vector<uint32_t> ChooseSkeleton(
    std::span<const MatchDatabase::VerifiedPair> pairs) {
  const Partners partners = FindPartners(pairs);
  std::map<uint32_t, int> missing;  // Partners that a photo still needs.
  for (const auto& [id, others] : partners) {
    missing[id] = std::min(kSkeletonPartners, static_cast<int>(others.size()));
  }
  const auto needed_by = [&](uint32_t id) {
    const std::vector<uint32_t>& others = partners.at(id);
    return std::count_if(others.begin(), others.end(), [&](uint32_t other) {
      return missing.at(other) > 0;
    });
  };
  // How many photos need a photo only falls, so the number is counted again
  // when it is its turn. Of equal ones the smaller id comes first: an entry is
  // the number and the negative id.
  std::priority_queue<std::pair<int64_t, int64_t>> queue;
  for (const auto& [id, others] : partners) {
    queue.emplace(needed_by(id), -static_cast<int64_t>(id));
  }
  std::vector<uint32_t> skeleton;
  while (!queue.empty()) {
    const auto [count, negative_id] = queue.top();
    queue.pop();
    const auto id = static_cast<uint32_t>(-negative_id);
    const int64_t count_now = needed_by(id);
    if (count_now == 0) continue;
    if (count_now < count) {
      queue.emplace(count_now, negative_id);
      continue;
    }
    skeleton.push_back(id);
    for (const uint32_t other : partners.at(id)) --missing.at(other);
  }
  std::sort(skeleton.begin(), skeleton.end());
  return skeleton;
}

StatusOr<Models> MapFromSkeleton(const StepContext& context,
                                 const fs::path& database,
                                 const fs::path& folder) {
  SfmInput part = context.input;
  FREEGS_ASSIGN_OR_RETURN(part.photos,
                          SkeletonPhotos(context.input.photos, database));
  if (part.photos.empty()) return Models();
  const StepContext part_context{
      part, context.options, context.colmap, context.num_threads};
  FREEGS_ASSIGN_OR_RETURN(
      Models models,
      MapFromBestPair(part_context,
                      database,
                      folder,
                      {.step = "mapping, part of the photos",
                       .further = true,
                       .listed = true}));
  if (static_cast<double>(NumRegistered(models)) <
      kGoodShare * static_cast<double>(part.photos.size())) {
    return UnusableResultError("only " + std::to_string(NumRegistered(models)) +
                               " of " + std::to_string(part.photos.size()) +
                               " chosen photos got a pose");
  }
  models.resize(1);
  FREEGS_ASSIGN_OR_RETURN(
      Reconstruction all,
      RegisterOtherPhotos(context, database, folder, models[0]));
  FREEGS_ASSIGN_OR_RETURN(
      models[0],
      TriangulatePoints(
          context, database, folder, WithoutPoints(std::move(all))));
  models[0] = WithoutBlindPhotos(models[0]);
  if (models[0].images.size() == context.input.photos.size()) return models;
  const Reconstruction start = std::move(models[0]);
  return MapPhotos(
      context,
      database,
      folder,
      {.step = "mapping, the rest", .further = true, .start = &start});
}

}  // namespace freegs::sfm
