// SPDX-License-Identifier: BSD-3-Clause
// The rungs in the order in which they are tried, and when each is worth
// trying.

#include "sfm/mapping/ladder.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sfm/diagnosis/photo_reasons.h"
#include "sfm/lookalikes/view_groups.h"
#include "sfm/mapping/ladder_rungs.h"
#include "sfm/matching/match_database.h"

namespace freegs::sfm {
namespace {

namespace fs = std::filesystem;
using Models = std::vector<Reconstruction>;

std::string Count(size_t count, const std::string& what) {
  return std::to_string(count) + " " + what + (count == 1 ? "" : "s");
}

class Ladder {
 public:
  Ladder(const StepContext& context,
         const DiagnosisOptions& diagnosis,
         AttemptStore* store)
      : context_(context), diagnosis_(diagnosis), store_(store) {}

  Status Start(const MatchedDatabase& database);
  Status Climb();
  LadderResult Take();

 private:
  struct Rung {
    const char* name;
    // Its estimated costs; see ladder_rungs.h for the unit.
    double (Ladder::*cost)() const;
    // Returns why it may help, or an empty string if it cannot.
    std::string (Ladder::*why)() const;
    StatusOr<AttemptResult> (*run)(const RungInput&);
  };
  static const std::array<Rung, 3> kRungs;

  // Reasons for trying a rung; empty if there is none.
  std::string LinkedPhotosMissing() const;
  std::string PairsWereLeftOut() const;
  std::string WeakPhotosMissing() const;

  // Estimated costs of a rung.
  double CostOfMapping() const { return kMappingCost; }
  double CostOfAllPairs() const;
  double CostOfFeatures() const { return kMoreFeaturesCost; }

  bool IsGood() const;
  bool IsHopeless() const;
  Status Look();  // Call it whenever models_ or database_ have changed.
  Status Try(const Rung& rung, const std::string& why);
  StatusOr<bool> IsBetter(const AttemptResult& result,
                          const fs::path& database) const;

  const StepContext& context_;
  const DiagnosisOptions& diagnosis_;
  AttemptStore* store_;

  Models models_;
  MatchedDatabase database_;
  std::vector<Attempt> attempts_;

  // Look() derives these from models_ and database_. Blurred photos are in none
  // of the three counts.
  SceneEvidence evidence_;
  size_t missing_ = 0;  // Photos that the best model lacks.
  size_t linked_ = 0;   // Of these, those that match photos of the model.
  size_t alone_ = 0;    // Of these, those in no group of kMinGroup photos.
};

// Cheap rungs come first.
const std::array<Ladder::Rung, 3> Ladder::kRungs = {{
    {"lower thresholds",
     &Ladder::CostOfMapping,
     &Ladder::LinkedPhotosMissing,
     &MapRelaxed},
    {"all pairs",
     &Ladder::CostOfAllPairs,
     &Ladder::PairsWereLeftOut,
     &MatchAllPairs},
    {"more features",
     &Ladder::CostOfFeatures,
     &Ladder::WeakPhotosMissing,
     &TakeMoreFeatures},
}};

std::string Ladder::LinkedPhotosMissing() const {
  if (models_.empty()) return "there is no model yet";
  if (linked_ == 0) return {};
  return Count(linked_, "photo") + " left out, though matching the model";
}

std::string Ladder::PairsWereLeftOut() const {
  if (database_.pairs.complete()) return {};
  return Count(missing_, "photo") + " left out, and not all pairs matched";
}

std::string Ladder::WeakPhotosMissing() const {
  if (models_.empty()) return "there is no model yet";
  // Photos of a separate group need no more features: they match each other.
  if (linked_ + alone_ == 0) return {};
  return Count(linked_ + alone_, "photo") + " with too few matches";
}

double Ladder::CostOfAllPairs() const {
  return kMatchingCost * static_cast<double>(database_.pairs.all_pairs) /
             std::max(1.0, static_cast<double>(database_.pairs.pairs)) +
         2 * kMappingCost;
}

bool Ladder::IsGood() const {
  const double got = static_cast<double>(NumRegistered(models_));
  return got > 0 &&
         got >= diagnosis_.good_share * (got + static_cast<double>(missing_));
}

bool Ladder::IsHopeless() const {
  const auto findings = Diagnose(evidence_, models_, diagnosis_);
  return std::any_of(findings.begin(),
                     findings.end(),
                     [](const Finding& finding) { return finding.hopeless; });
}

Status Ladder::Look() {
  {
    FREEGS_ASSIGN_OR_RETURN(const MatchDatabase database,
                            MatchDatabase::Open(database_.path));
    FREEGS_ASSIGN_OR_RETURN(evidence_,
                            CollectEvidence(context_.input.photos, database));
  }
  const PhotoGroups groups = GroupByMatches(evidence_, models_);
  const size_t count = evidence_.photos.size();
  // Even few matches with a photo of the model may be enough to place another.
  std::vector<bool> linked(count, false);
  for (const PairEvidence& pair : evidence_.pairs) {
    const bool first = groups.registered[pair.first];
    const bool second = groups.registered[pair.second];
    if (first) linked[pair.second] = true;
    if (second) linked[pair.first] = true;
  }
  const std::vector<bool> blurred = FindBlurredPhotos(evidence_, diagnosis_);
  missing_ = linked_ = alone_ = 0;
  for (size_t i = 0; i < count; ++i) {
    if (groups.registered[i] || blurred[i]) continue;
    ++missing_;
    const size_t size = groups.members[groups.group[i]].size();
    const bool main = groups.group[i] == 0 && !models_.empty();
    if (!main && size >= kMinGroup) continue;  // A part of its own.
    ++(main || linked[i] ? linked_ : alone_);
  }
  return {};
}

// A result is better with more photos, or with as many and clearly more points
// that fit as well. A model that look-alikes glued never replaces one that
// holds together.
StatusOr<bool> Ladder::IsBetter(const AttemptResult& result,
                                const fs::path& database) const {
  if (result.models.empty()) return false;
  if (models_.empty()) return true;
  const Attempt now = DescribeAttempt("", "", models_);
  const Attempt then = DescribeAttempt("", "", result.models);
  if (then.registered < now.registered) return false;
  if (then.registered == now.registered &&
      (then.points * 10 < now.points * 12 ||
       then.mean_error_px > 1.2 * now.mean_error_px)) {
    return false;
  }
  FREEGS_ASSIGN_OR_RETURN(const ViewGroups after,
                          GroupViews(result.models[0], database));
  if (after.consistent()) return true;
  FREEGS_ASSIGN_OR_RETURN(const ViewGroups before,
                          GroupViews(models_[0], database_.path));
  return !before.consistent();
}

Status Ladder::Start(const MatchedDatabase& database) {
  database_ = database;
  const std::string name = "mapping";
  FREEGS_ASSIGN_OR_RETURN(
      AttemptResult result, store_->Run(name, [&]() -> StatusOr<AttemptResult> {
        AttemptResult made;
        FREEGS_ASSIGN_OR_RETURN(
            made.models,
            MapPhotos(
                context_, database_.path, store_->Folder(name) / "mapper", {}));
        return made;
      }));
  models_ = std::move(result.models);
  attempts_.push_back(DescribeAttempt(name, "", models_));
  attempts_.back().kept = !models_.empty();
  return Look();
}

Status Ladder::Try(const Rung& rung, const std::string& why) {
  FREEGS_ASSIGN_OR_RETURN(AttemptResult result, store_->Try(rung.name, [&] {
    return rung.run(
        {context_, rung.name, models_, database_, store_->Folder(rung.name)});
  }));
  attempts_.push_back(DescribeAttempt(rung.name, why, result.models));
  attempts_.back().problem = result.problem;
  MatchedDatabase database = store_->DatabaseOf(rung.name, result, database_);
  bool better = false;
  // The database of an attempt that was not kept is gone.
  if (fs::exists(database.path)) {
    FREEGS_ASSIGN_OR_RETURN(better, IsBetter(result, database.path));
  }
  if (!better) {
    store_->RemoveDatabaseOf(rung.name);
    return {};
  }
  attempts_.back().kept = true;
  models_ = std::move(result.models);
  database_ = std::move(database);
  return Look();
}

Status Ladder::Climb() {
  double spent = 0;
  for (const Rung& rung : kRungs) {
    if (IsGood() || IsHopeless()) break;
    const std::string why = (this->*rung.why)();
    if (why.empty()) continue;
    const double cost = (this->*rung.cost)();
    if (spent + cost > context_.options.max_retry_cost) {
      attempts_.push_back(DescribeAttempt(rung.name, why, {}));
      attempts_.back().problem =
          "not tried: it costs about " +
          std::to_string(static_cast<int>(std::ceil(cost))) +
          " times as much as the plain way (sfm.max_retry_cost)";
      continue;
    }
    spent += cost;
    FREEGS_RETURN_IF_ERROR(Try(rung, why));
  }
  return {};
}

LadderResult Ladder::Take() {
  return {std::move(models_),
          std::move(database_),
          std::move(evidence_),
          std::move(attempts_)};
}

}  // namespace

StatusOr<LadderResult> ClimbLadder(const StepContext& context,
                                   const MatchedDatabase& database,
                                   const DiagnosisOptions& diagnosis,
                                   AttemptStore* store) {
  Ladder ladder(context, diagnosis, store);
  FREEGS_RETURN_IF_ERROR(ladder.Start(database));
  FREEGS_RETURN_IF_ERROR(ladder.Climb());
  return ladder.Take();
}

}  // namespace freegs::sfm
