// SPDX-License-Identifier: BSD-3-Clause
// The repairs of a glued model, in order.

#include "sfm/mapping/separate_parts.h"

#include <algorithm>
#include <set>
#include <utility>

#include "core/number_text.h"
#include "sfm/lookalikes/view_groups.h"
#include "sfm/mapping/ladder_rungs.h"
#include "sfm/matching/match_database.h"

namespace freegs::sfm {
namespace {

namespace fs = std::filesystem;
using Models = std::vector<Reconstruction>;

constexpr int kMaxPartRounds = 3;
constexpr size_t kMinPart = 3;  // Photos of a part that makes a model.

struct Candidate {
  Reconstruction model;
  ViewGroups groups;
  MatchedDatabase database;

  size_t largest() const { return groups.groups[0].size(); }
};

class Separation {
 public:
  Separation(const StepContext& context, AttemptStore* store)
      : context_(context), store_(store) {}

  StatusOr<SeparatedParts> Run(const MatchedDatabase& database,
                               const Models& models);

 private:
  bool IsGood() const {
    return best_.groups.consistent() &&
           best_.model.images.size() * 10 >= registered_ * 9;
  }
  std::string Why() const;
  // Maps without the pairs that glued the candidate, in several rounds. What is
  // made is always checked against all matches of the candidate's database.
  StatusOr<AttemptResult> MapWithout(const std::string& name,
                                     Candidate candidate) const;
  // Keeps what an attempt made if its largest group is larger than before.
  Status Judge(const std::string& name,
               const std::string& why,
               const AttemptResult& result,
               const MatchedDatabase& database);
  Status Unglue(const std::string& name);
  Status TakeFeatures(const Models& models);
  void TakeApart(SeparatedParts* result) const;

  const StepContext& context_;
  AttemptStore* store_;
  size_t registered_ = 0;  // Photos of the model given.
  Candidate best_;
  std::vector<Attempt> attempts_;
};

std::string Separation::Why() const {
  return "groups of " + std::to_string(best_.largest()) + " and " +
         std::to_string(best_.model.images.size() - best_.largest()) +
         " photos hold together by what looks alike (support " +
         FormatFixed(best_.groups.score, 2) + ")";
}

StatusOr<AttemptResult> Separation::MapWithout(const std::string& name,
                                               Candidate candidate) const {
  const fs::path folder = store_->Folder(name);
  const fs::path trusted = folder / "trusted.db";
  FREEGS_RETURN_IF_ERROR(CopyDatabase(candidate.database.path, trusted));
  AttemptResult result;
  size_t largest = 0;
  for (int round = 0; round < kMaxPartRounds; ++round) {
    if (candidate.groups.suspects.empty()) break;
    FREEGS_RETURN_IF_ERROR(
        RemoveVerifiedPairs(trusted, candidate.groups.suspects));
    FREEGS_ASSIGN_OR_RETURN(
        Models again,
        MapBest(context_, trusted, folder / "mapper", registered_));
    if (again.empty()) break;
    FREEGS_ASSIGN_OR_RETURN(candidate.groups,
                            GroupViews(again[0], candidate.database.path));
    if (candidate.largest() > largest) {
      largest = candidate.largest();
      result.models = std::move(again);
    }
    if (candidate.groups.consistent()) break;
  }
  RemoveDatabase(trusted);
  return result;
}

Status Separation::Judge(const std::string& name,
                         const std::string& why,
                         const AttemptResult& result,
                         const MatchedDatabase& database) {
  attempts_.push_back(DescribeAttempt(name, why, result.models));
  attempts_.back().problem = result.problem;
  if (result.models.empty() || !fs::exists(database.path)) return {};
  Candidate made;
  made.model = result.models[0];
  made.database = database;
  FREEGS_ASSIGN_OR_RETURN(made.groups, GroupViews(made.model, database.path));
  if (made.largest() > best_.largest()) {
    best_ = std::move(made);
    attempts_.back().kept = true;
  } else if (!made.groups.consistent()) {
    attempts_.back().problem = "its photos do not hold together either";
  }
  return {};
}

Status Separation::Unglue(const std::string& name) {
  const std::string why = Why();
  const MatchedDatabase database = best_.database;
  FREEGS_ASSIGN_OR_RETURN(const AttemptResult result, store_->Run(name, [&] {
    return MapWithout(name, best_);
  }));
  return Judge(name, why, result, database);
}

Status Separation::TakeFeatures(const Models& models) {
  const std::string name = "more features against look-alikes";
  const std::string why = Why();
  if (kMoreFeaturesCost > context_.options.max_retry_cost) {
    attempts_.push_back(DescribeAttempt(name, why, {}));
    attempts_.back().problem =
        "not tried: it costs more than sfm.max_retry_cost allows";
    return {};
  }
  FREEGS_ASSIGN_OR_RETURN(const AttemptResult result, store_->Try(name, [&] {
    return TakeMoreFeatures(
        {context_, name, models, best_.database, store_->Folder(name)});
  }));
  FREEGS_RETURN_IF_ERROR(Judge(
      name, why, result, store_->DatabaseOf(name, result, best_.database)));
  // More features may glue parts, too; but they tell better which pairs did.
  if (!IsGood() && attempts_.back().kept && !best_.groups.consistent()) {
    FREEGS_RETURN_IF_ERROR(Unglue("more features, without look-alike parts"));
  }
  return {};
}

// Makes a model of each group that is large enough.
void Separation::TakeApart(SeparatedParts* result) const {
  for (const std::vector<uint32_t>& group : best_.groups.groups) {
    if (!result->models.empty() && group.size() < kMinPart) continue;
    result->models.push_back(RestrictTo(best_.model, group));
  }
}

StatusOr<SeparatedParts> Separation::Run(const MatchedDatabase& database,
                                         const Models& models) {
  SeparatedParts result;
  registered_ = models[0].images.size();
  best_.model = models[0];
  best_.database = database;
  FREEGS_ASSIGN_OR_RETURN(best_.groups, GroupViews(models[0], database.path));
  result.score = best_.groups.score;
  result.groups = best_.groups.groups.size();
  if (best_.groups.consistent()) return result;

  FREEGS_RETURN_IF_ERROR(Unglue("without look-alike parts"));
  if (!IsGood()) FREEGS_RETURN_IF_ERROR(TakeFeatures(models));
  TakeApart(&result);
  result.database = best_.database;
  result.attempts = std::move(attempts_);
  std::set<std::string> placed;
  for (const PosedImage& image : result.models[0].images) {
    placed.insert(image.name);
  }
  for (const PosedImage& image : models[0].images) {
    if (!placed.contains(image.name)) result.unplaced.push_back(image.name);
  }
  std::sort(result.unplaced.begin(), result.unplaced.end());
  return result;
}

}  // namespace

StatusOr<SeparatedParts> SeparateParts(const StepContext& context,
                                       const MatchedDatabase& database,
                                       const Models& models,
                                       AttemptStore* store) {
  if (models.empty()) return SeparatedParts();
  return Separation(context, store).Run(database, models);
}

}  // namespace freegs::sfm
