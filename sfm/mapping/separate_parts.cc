// SPDX-License-Identifier: BSD-3-Clause
// The repair of a glued model.

#include "sfm/mapping/separate_parts.h"

#include <set>
#include <utility>

#include "core/number_text.h"
#include "sfm/lookalikes/view_groups.h"
#include "sfm/matching/match_database.h"

namespace freegs::sfm {
namespace {

namespace fs = std::filesystem;
using Models = std::vector<Reconstruction>;

constexpr int kMaxRounds = 3;
constexpr size_t kMinPart = 3;  // Photos of a part that makes a model.

constexpr char kName[] = "without look-alike parts";

struct Candidate {
  Reconstruction model;
  ViewGroups groups;

  size_t largest() const { return groups.groups[0].size(); }
};

std::string Why(const Candidate& glued) {
  return "groups of " + std::to_string(glued.largest()) + " and " +
         std::to_string(glued.model.images.size() - glued.largest()) +
         " photos hold together by what looks alike (support " +
         FormatFixed(glued.groups.score, 2) + ")";
}

// Maps without the pairs that glued the model, and without those that glue what
// comes of it, as long as the largest group of photos that hold together grows.
// Whether they do is judged by all matches, not only by those that were mapped.
StatusOr<AttemptResult> MapWithout(const StepContext& context,
                                   const fs::path& database,
                                   const fs::path& folder,
                                   Candidate candidate) {
  const fs::path trusted = folder / "trusted.db";
  const size_t registered = candidate.model.images.size();
  FREEGS_RETURN_IF_ERROR(CopyDatabase(database, trusted));
  AttemptResult result;
  size_t largest = 0;
  for (int round = 0; round < kMaxRounds; ++round) {
    if (candidate.groups.suspects.empty()) break;
    FREEGS_RETURN_IF_ERROR(
        RemoveVerifiedPairs(trusted, candidate.groups.suspects));
    FREEGS_ASSIGN_OR_RETURN(
        Models again, MapBest(context, trusted, folder / "mapper", registered));
    if (again.empty()) break;
    FREEGS_ASSIGN_OR_RETURN(candidate.groups, GroupViews(again[0], database));
    if (candidate.largest() <= largest) break;
    largest = candidate.largest();
    result.models = std::move(again);
    if (candidate.groups.consistent()) break;
  }
  RemoveDatabase(trusted);
  return result;
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
                                       AttemptStore* store) {
  SeparatedParts result;
  if (models.empty()) return result;
  Candidate best;
  best.model = models[0];
  FREEGS_ASSIGN_OR_RETURN(best.groups, GroupViews(best.model, database));
  result.score = best.groups.score;
  result.groups = best.groups.groups.size();
  if (best.groups.consistent()) return result;

  FREEGS_ASSIGN_OR_RETURN(AttemptResult again, store->Run(kName, [&] {
    return MapWithout(context, database, store->Folder(kName), best);
  }));
  result.attempt = DescribeAttempt(kName, Why(best), again.models);
  if (!again.models.empty()) {
    Candidate made;
    made.model = std::move(again.models[0]);
    FREEGS_ASSIGN_OR_RETURN(made.groups, GroupViews(made.model, database));
    if (made.largest() > best.largest()) {
      best = std::move(made);
      result.attempt.kept = true;
    } else {
      result.attempt.problem = "its photos do not hold together either";
    }
  }
  result.models = TakeApart(best);
  result.unplaced = Lost(models[0], result.models[0]);
  return result;
}

}  // namespace freegs::sfm
