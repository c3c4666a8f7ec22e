// SPDX-License-Identifier: BSD-3-Clause
// The repair of a glued model.

#include "sfm/mapping/separate_parts.h"

#include <set>
#include <utility>

#include "core/number_text.h"
#include "sfm/lookalikes/view_groups.h"
#include "sfm/mapping/initial_pair.h"
#include "sfm/matching/match_database.h"

namespace freegs::sfm {
namespace {

namespace fs = std::filesystem;
using Models = std::vector<Reconstruction>;

constexpr int kMaxRounds = 3;
constexpr size_t kMinPart = 3;  // Photos of a part that makes a model.

// The largest group of a model may have a misplaced photo of its own, against
// which little speaks. That happened with 15 photos. To map few photos anew
// takes little time, so a group is kept only in models with so many photos. The
// number was not measured.
constexpr size_t kManyPhotos = 50;

struct Candidate {
  Reconstruction model;
  ViewGroups groups;

  size_t photos() const { return model.images.size(); }
  size_t largest() const { return groups.groups[0].size(); }
};

// The two ways of repairing a model.
enum class Repair {
  kPlaceAgain,  // Its largest group stays; the other photos are placed again.
  kMapAnew,     // Nothing of it stays.
};

std::string Name(Repair repair) {
  return repair == Repair::kPlaceAgain ? "misplaced photos once more"
                                       : "without look-alike parts";
}

std::string Why(const Candidate& glued) {
  return "groups of " + std::to_string(glued.largest()) + " and " +
         std::to_string(glued.photos() - glued.largest()) +
         " photos hold together by what looks alike (support " +
         FormatFixed(glued.groups.score, 2) + ")";
}

// Whether COLMAP made nothing of use. Models that are there already stay then.
bool IsUnusable(const StatusOr<Models>& mapped) {
  return mapped.status().code() == StatusCode::kUnusableResult;
}

// Maps a scene again without the pairs that glued a model of it.
class Remapping {
 public:
  Remapping(const StepContext& context, const fs::path& database, size_t skip)
      : context_(context), database_(database), skip_(skip) {}

  // Maps without the pairs that glued the model, and without those that glue
  // what comes of it, as long as the largest group of photos that hold together
  // grows. Whether they do is judged by all matches, not only by those that
  // were mapped.
  StatusOr<AttemptResult> Run(const fs::path& folder,
                              Repair repair,
                              Candidate candidate) const;

 private:
  StatusOr<Models> MapOnce(const fs::path& trusted,
                           const fs::path& folder,
                           Repair repair,
                           const Candidate& candidate,
                           size_t wanted) const;
  StatusOr<Models> MapFromPair(const fs::path& trusted,
                               const fs::path& folder) const;
  StatusOr<Models> MapAnew(const fs::path& trusted,
                           const fs::path& folder,
                           size_t wanted) const;

  const StepContext& context_;
  const fs::path& database_;
  size_t skip_;
};

StatusOr<AttemptResult> Remapping::Run(const fs::path& folder,
                                       Repair repair,
                                       Candidate candidate) const {
  const fs::path trusted = folder / "trusted.db";
  FREEGS_RETURN_IF_ERROR(CopyDatabase(database_, trusted));
  const size_t wanted = candidate.photos();
  AttemptResult result;
  size_t largest = 0;
  for (int round = 0; round < kMaxRounds; ++round) {
    if (candidate.groups.suspects.empty()) break;
    FREEGS_RETURN_IF_ERROR(
        RemoveVerifiedPairs(trusted, candidate.groups.suspects));
    StatusOr<Models> mapped =
        MapOnce(trusted, folder / "mapper", repair, candidate, wanted);
    if (IsUnusable(mapped) && !result.models.empty()) break;
    FREEGS_ASSIGN_OR_RETURN(Models again, std::move(mapped));
    if (again.empty()) break;
    candidate.model = again[0];
    FREEGS_ASSIGN_OR_RETURN(candidate.groups,
                            GroupViews(candidate.model, database_));
    if (candidate.largest() <= largest) break;
    largest = candidate.largest();
    result.models = std::move(again);
    if (candidate.groups.consistent()) break;
  }
  RemoveDatabase(trusted);
  return result;
}

// `wanted` is the number of photos that the first model had.
StatusOr<Models> Remapping::MapOnce(const fs::path& trusted,
                                    const fs::path& folder,
                                    Repair repair,
                                    const Candidate& candidate,
                                    size_t wanted) const {
  if (repair == Repair::kMapAnew) return MapAnew(trusted, folder, wanted);
  const Reconstruction rest =
      RestrictTo(candidate.model, candidate.groups.groups[0]);
  return MapPhotos(
      context_,
      trusted,
      folder,
      {.step = "misplaced photos", .further = true, .start = &rest});
}

// Maps from the best pair after `skip_` others. Where there are not so many,
// there is no model.
StatusOr<Models> Remapping::MapFromPair(const fs::path& trusted,
                                        const fs::path& folder) const {
  const MapperOptions options = {.further = true};
  if (skip_ == 0) return MapFromBestPair(context_, trusted, folder, options);
  FREEGS_ASSIGN_OR_RETURN(const std::vector<InitialPair> pairs,
                          BestPairs(context_.input.photos, skip_ + 1, trusted));
  if (pairs.size() <= skip_) return Models();
  return MapFromLastPair(context_, trusted, folder, pairs, options);
}

// Maps from a pair. When the largest model lacks many of the `wanted` photos,
// it tries again with lower thresholds and returns the better result.
StatusOr<Models> Remapping::MapAnew(const fs::path& trusted,
                                    const fs::path& folder,
                                    size_t wanted) const {
  FREEGS_ASSIGN_OR_RETURN(Models models, MapFromPair(trusted, folder));
  if (NumRegistered(models) * 10 >= wanted * 9) return models;
  StatusOr<Models> relaxed = MapPhotos(
      context_,
      trusted,
      folder,
      {.step = "mapping, lower thresholds", .further = true, .relaxed = true});
  if (IsUnusable(relaxed) && !models.empty()) return models;
  FREEGS_RETURN_IF_ERROR(relaxed.status());
  return NumRegistered(*relaxed) > NumRegistered(models) ? *relaxed : models;
}

// A model of each group that is large enough.
Models TakeApart(const Candidate& candidate) {
  Models models;
  for (const std::vector<uint32_t>& group : candidate.groups.groups) {
    if (!models.empty() && group.size() < kMinPart) continue;
    models.push_back(RestrictTo(candidate.model, group));
  }
  return models;
}

// Names of the photos that `before` has and `after` lacks, ascending.
std::vector<std::string> Lost(const Reconstruction& before,
                              const Reconstruction& after) {
  std::set<std::string> names;
  for (const PosedImage& image : before.images) names.insert(image.name);
  for (const PosedImage& image : after.images) names.erase(image.name);
  return {names.begin(), names.end()};
}

}  // namespace

StatusOr<SeparatedParts> SeparateParts(const StepContext& context,
                                       const fs::path& database,
                                       const Models& models,
                                       AttemptStore* store,
                                       size_t skip,
                                       const std::string& suffix) {
  SeparatedParts result;
  if (models.empty()) return result;
  Candidate best;
  best.model = models[0];
  FREEGS_ASSIGN_OR_RETURN(best.groups, GroupViews(best.model, database));
  result.score = best.groups.score;
  result.groups = best.groups.groups.size();
  if (best.groups.consistent()) return result;

  const Candidate glued = best;
  const Remapping remapping(context, database, skip);
  for (const Repair repair : {Repair::kPlaceAgain, Repair::kMapAnew}) {
    // A small group is no ground to build on.
    if (repair == Repair::kPlaceAgain &&
        (glued.photos() < kManyPhotos ||
         2 * glued.largest() < glued.photos())) {
      continue;
    }
    const std::string name = Name(repair) + suffix;
    FREEGS_ASSIGN_OR_RETURN(AttemptResult again, store->Try(name, [&] {
      return remapping.Run(store->Folder(name), repair, glued);
    }));
    Attempt attempt = DescribeAttempt(name, Why(glued), again.models);
    attempt.problem = std::move(again.problem);
    if (!again.models.empty()) {
      Candidate made;
      made.model = std::move(again.models[0]);
      FREEGS_ASSIGN_OR_RETURN(made.groups, GroupViews(made.model, database));
      attempt.kept = made.largest() > best.largest();
      if (attempt.kept) {
        best = std::move(made);
      } else {
        attempt.problem = made.groups.consistent()
                              ? "it places no more photos"
                              : "its photos do not hold together either";
      }
    }
    result.attempts.push_back(std::move(attempt));
    if (best.groups.consistent()) break;
  }
  result.models = TakeApart(best);
  result.unplaced = Lost(models[0], result.models[0]);
  // They stay behind, even if they have more photos: nobody checked whether
  // they are glued, and what is said about photos without a place is about the
  // parts of the first one.
  AddOthers(models, &result.models);
  return result;
}

}  // namespace freegs::sfm
