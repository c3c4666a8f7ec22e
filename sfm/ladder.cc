// SPDX-License-Identifier: BSD-3-Clause
// The rungs, from cheap to dear.

#include "sfm/ladder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <system_error>

#include "core/files.h"
#include "sfm/health.h"
#include "sfm/match_database.h"
#include "sfm/model_io.h"
#include "sfm/view_graph.h"

namespace freegs::sfm {
namespace {

namespace fs = std::filesystem;
using Models = std::vector<Reconstruction>;

// Costs are multiples of what the plain way costs: features, matching, mapping.
constexpr double kMapping = 0.2;
constexpr double kMatching = 0.7;
constexpr double kFeatures = 0.1;

constexpr int kMoreFeatures = 2;         // Times sfm.max_features.
constexpr double kLooseRatio = 0.9;      // Instead of 0.8.
constexpr double kLooseAngle = 0.9;      // Instead of 0.7, radians.
constexpr double kLowContrast = 0.0025;  // COLMAP's default is 0.0067.
constexpr size_t kManyPhotos = 100;
constexpr size_t kSharedPhotos = 3;  // Two models need these to be merged.

size_t NumRegistered(const Models& models) {
  return models.empty() ? 0 : models[0].images.size();
}

std::string Count(size_t count, const std::string& what) {
  return std::to_string(count) + " " + what + (count == 1 ? "" : "s");
}

size_t NumShared(const Reconstruction& a, const Reconstruction& b) {
  std::set<std::string> names;
  for (const PosedImage& image : a.images) names.insert(image.name);
  return static_cast<size_t>(std::count_if(
      b.images.begin(), b.images.end(), [&](const PosedImage& image) {
        return names.contains(image.name);
      }));
}

class Ladder {
 public:
  Ladder(const StepContext& context,
         const DiagnosisOptions& diagnosis,
         AttemptStore* store)
      : context_(context), diagnosis_(diagnosis), store_(store) {}

  Status Start(const fs::path& database, int64_t matched_pairs);
  Status Climb();
  LadderResult Take();

 private:
  struct Rung {
    const char* name;
    double (Ladder::*cost)() const;
    // Why it may help, or nothing.
    std::string (Ladder::*why)() const;
    StatusOr<AttemptResult> (Ladder::*run)(const Rung&);
  };
  static const std::array<Rung, 8> kRungs;

  // When a rung may help.
  std::string LinkedPhotosMissing() const;
  std::string ModelsShare() const;
  std::string ModelIsIncomplete() const;
  std::string PairsWereLeftOut() const;
  std::string PhotosMissing() const;
  std::string WeakPhotosMissing() const;
  std::string OtherMapperMayHelp() const;

  // What it costs.
  double CostOfMapping() const { return kMapping; }
  double CostOfAllPairs() const;
  double CostOfMatching() const { return kMatching + 2 * kMapping; }
  double CostOfFeatures() const;

  // What it does.
  StatusOr<AttemptResult> MapRelaxed(const Rung& rung);
  StatusOr<AttemptResult> MapWithOtherSeed(const Rung& rung);
  StatusOr<AttemptResult> Merge(const Rung& rung);
  StatusOr<AttemptResult> AddPhotos(const Rung& rung);
  StatusOr<AttemptResult> MatchAllPairs(const Rung& rung);
  StatusOr<AttemptResult> MatchLoosely(const Rung& rung);
  StatusOr<AttemptResult> TakeMoreFeatures(const Rung& rung);
  StatusOr<AttemptResult> MapOtherwise(const Rung& rung);

  StatusOr<AttemptResult> MapWith(const Rung& rung, Mapping mapping);
  StatusOr<AttemptResult> MatchAgain(const Rung& rung,
                                     const SfmOptions& options,
                                     const DescriptorMatchingOptions& matching);
  fs::path Scratch(const Rung& rung) const {
    return store_->Folder(rung.name) / "mapper";
  }

  bool IsGood() const;
  bool IsHopeless() const;
  Status Look();  // Brings evidence_ and the counts below up to date.
  Status Try(const Rung& rung, const std::string& why);
  StatusOr<bool> IsBetter(const AttemptResult& result,
                          const fs::path& database) const;
  Attempt Note(const std::string& name,
               const std::string& why,
               const Models& models) const;

  const StepContext& context_;
  const DiagnosisOptions& diagnosis_;
  AttemptStore* store_;

  Models models_;
  fs::path database_;
  int64_t matched_pairs_ = 0;
  std::vector<Attempt> attempts_;

  // What is known about models_ and database_.
  SceneEvidence evidence_;
  size_t missing_ = 0;  // Photos that the best model lacks.
  size_t linked_ = 0;   // Of them, those that match photos of the model.
  size_t alone_ = 0;    // Of them, those that match none, nor one another.
};

// The order is the order of costs, except that what needs a mapper of another
// kind, which is less robust, comes last.
const std::array<Ladder::Rung, 8> Ladder::kRungs = {{
    {"lower thresholds",
     &Ladder::CostOfMapping,
     &Ladder::LinkedPhotosMissing,
     &Ladder::MapRelaxed},
    {"another seed",
     &Ladder::CostOfMapping,
     &Ladder::LinkedPhotosMissing,
     &Ladder::MapWithOtherSeed},
    {"merged models",
     &Ladder::CostOfMapping,
     &Ladder::ModelsShare,
     &Ladder::Merge},
    {"added photos",
     &Ladder::CostOfMapping,
     &Ladder::ModelIsIncomplete,
     &Ladder::AddPhotos},
    {"all pairs",
     &Ladder::CostOfAllPairs,
     &Ladder::PairsWereLeftOut,
     &Ladder::MatchAllPairs},
    {"looser matches",
     &Ladder::CostOfMatching,
     &Ladder::PhotosMissing,
     &Ladder::MatchLoosely},
    {"more features",
     &Ladder::CostOfFeatures,
     &Ladder::WeakPhotosMissing,
     &Ladder::TakeMoreFeatures},
    {"another mapper",
     &Ladder::CostOfMapping,
     &Ladder::OtherMapperMayHelp,
     &Ladder::MapOtherwise},
}};

std::string Ladder::LinkedPhotosMissing() const {
  if (models_.empty()) return "there is no model yet";
  if (linked_ == 0) return {};
  return Count(linked_, "photo") + " left out, though matching the model";
}

std::string Ladder::ModelsShare() const {
  for (size_t k = 1; k < models_.size(); ++k) {
    const size_t shared = NumShared(models_[0], models_[k]);
    if (shared >= kSharedPhotos && shared < models_[k].images.size()) {
      return "models share " + Count(shared, "photo");
    }
  }
  return {};
}

std::string Ladder::ModelIsIncomplete() const {
  return models_.empty() ? std::string() : LinkedPhotosMissing();
}

std::string Ladder::PairsWereLeftOut() const {
  if (evidence_.all_pairs_compared()) return {};
  return Count(missing_, "photo") + " left out, and not all pairs compared";
}

std::string Ladder::PhotosMissing() const {
  return Count(missing_, "photo") + " left out";
}

std::string Ladder::WeakPhotosMissing() const {
  // A group of its own has enough features: it found its members.
  if (!models_.empty() && linked_ + alone_ == 0) return {};
  return Count(linked_ + alone_, "photo") + " with too few matches";
}

std::string Ladder::OtherMapperMayHelp() const {
  const bool hierarchical = context_.input.photos.size() >= kManyPhotos &&
                            context_.colmap.HasCommand("hierarchical_mapper");
  if (!hierarchical && !context_.colmap.HasCommand("global_mapper")) return {};
  return LinkedPhotosMissing();
}

double Ladder::CostOfAllPairs() const {
  const double count = static_cast<double>(evidence_.photos.size());
  const double pairs = count * (count - 1) / 2;
  return kMatching * pairs /
             std::max(1.0, static_cast<double>(matched_pairs_)) +
         2 * kMapping;
}

double Ladder::CostOfFeatures() const {
  return kFeatures * kMoreFeatures + kMatching * kMoreFeatures * kMoreFeatures +
         2 * kMapping;
}

StatusOr<AttemptResult> Ladder::MapWith(const Rung& rung, Mapping mapping) {
  mapping.step = std::string("mapping, ") + rung.name;
  AttemptResult result;
  FREEGS_ASSIGN_OR_RETURN(
      result.models, MapPhotos(context_, database_, Scratch(rung), mapping));
  SortBySize(&result.models);
  std::error_code ignored;
  fs::remove_all(Scratch(rung), ignored);
  return result;
}

StatusOr<AttemptResult> Ladder::MapRelaxed(const Rung& rung) {
  Mapping mapping;
  mapping.relaxed = true;
  return MapWith(rung, mapping);
}

StatusOr<AttemptResult> Ladder::MapWithOtherSeed(const Rung& rung) {
  Mapping mapping;
  mapping.seed_offset = 1;
  return MapWith(rung, mapping);
}

// Merging leaves two versions of shared photos' points, and no adjustment: the
// mapper then goes on from there, which does both.
StatusOr<AttemptResult> Ladder::Merge(const Rung& rung) {
  const fs::path folder = store_->Folder(rung.name);
  fs::path merged = folder / "start";
  FREEGS_RETURN_IF_ERROR(WriteModel(merged, models_[0]));
  bool any = false;
  Reconstruction whole = models_[0];
  for (size_t k = 1; k < models_.size(); ++k) {
    if (NumShared(whole, models_[k]) < kSharedPhotos) continue;
    const fs::path other = folder / ("other" + std::to_string(k));
    const fs::path both = folder / ("merged" + std::to_string(k));
    FREEGS_RETURN_IF_ERROR(WriteModel(other, models_[k]));
    FREEGS_ASSIGN_OR_RETURN(const bool done,
                            MergeModels(context_, merged, other, both));
    if (!done) continue;
    FREEGS_ASSIGN_OR_RETURN(Reconstruction model, ReadModel(both));
    if (model.images.size() <= whole.images.size()) continue;
    whole = std::move(model);
    merged = both;
    any = true;
  }
  if (!any) return AttemptResult();
  Mapping mapping;
  mapping.start = merged;
  return MapWith(rung, mapping);
}

StatusOr<AttemptResult> Ladder::AddPhotos(const Rung& rung) {
  Mapping mapping;
  mapping.relaxed = true;
  mapping.start = store_->Folder(rung.name) / "start";
  FREEGS_RETURN_IF_ERROR(WriteModel(mapping.start, models_[0]));
  return MapWith(rung, mapping);
}

StatusOr<AttemptResult> Ladder::MatchAgain(
    const Rung& rung,
    const SfmOptions& options,
    const DescriptorMatchingOptions& matching) {
  StepContext context{context_.input, options, context_.colmap};
  context.num_threads = context_.num_threads;
  context.matching = matching;
  const fs::path database = store_->Database(rung.name);
  {
    FREEGS_ASSIGN_OR_RETURN(const MatchDatabase known,
                            MatchDatabase::Open(database_));
    FREEGS_RETURN_IF_ERROR(known.CopyTo(database));
  }
  FREEGS_RETURN_IF_ERROR(
      MatchFeatures(context, database, {}, [](int) { return Status(); }));
  AttemptResult result;
  result.has_database = true;
  FREEGS_ASSIGN_OR_RETURN(result.models,
                          MapBest(context, database, Scratch(rung)));
  return result;
}

StatusOr<AttemptResult> Ladder::MatchAllPairs(const Rung& rung) {
  SfmOptions options = context_.options;
  options.matcher = "exhaustive";
  return MatchAgain(rung, options, context_.matching);
}

StatusOr<AttemptResult> Ladder::MatchLoosely(const Rung& rung) {
  SfmOptions options = context_.options;
  if (evidence_.all_pairs_compared()) options.matcher = "exhaustive";
  return MatchAgain(rung, options, {kLooseRatio, kLooseAngle});
}

StatusOr<AttemptResult> Ladder::TakeMoreFeatures(const Rung& rung) {
  SfmOptions options = context_.options;
  if (evidence_.all_pairs_compared()) options.matcher = "exhaustive";
  options.max_features *= kMoreFeatures;
  options.max_image_size += options.max_image_size / 2;
  StepContext context{context_.input, options, context_.colmap};
  context.num_threads = context_.num_threads;
  context.peak_threshold = kLowContrast;
  const fs::path database = store_->Database(rung.name);
  FREEGS_ASSIGN_OR_RETURN(const bool numbered,
                          RegisterPhotos(context, database));
  FREEGS_RETURN_IF_ERROR(
      ExtractFeatures(context, database, numbered ? context.num_threads : 1));
  FREEGS_RETURN_IF_ERROR(
      MatchFeatures(context, database, {}, [](int) { return Status(); }));
  AttemptResult result;
  result.has_database = true;
  FREEGS_ASSIGN_OR_RETURN(result.models,
                          MapBest(context, database, Scratch(rung)));
  return result;
}

// COLMAP 4's global mapper; for many photos, the hierarchical one that older
// releases have.
StatusOr<AttemptResult> Ladder::MapOtherwise(const Rung& rung) {
  Mapping mapping;
  mapping.command = context_.colmap.HasCommand("global_mapper")
                        ? "global_mapper"
                        : "hierarchical_mapper";
  return MapWith(rung, mapping);
}

bool Ladder::IsGood() const {
  return static_cast<double>(NumRegistered(models_)) >=
         diagnosis_.good_share *
             static_cast<double>(context_.input.photos.size());
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
                            MatchDatabase::Open(database_));
    FREEGS_ASSIGN_OR_RETURN(
        evidence_,
        CollectEvidence(context_.input.photos, database, matched_pairs_));
  }
  const PhotoGroups groups = GroupByMatches(evidence_, models_);
  const size_t count = evidence_.photos.size();
  // Even few matches with a photo of the model may be enough to place another.
  std::vector<bool> linked(count, false);
  for (const PairEvidence& pair : evidence_.pairs) {
    if (groups.registered[pair.first]) linked[pair.second] = true;
    if (groups.registered[pair.second]) linked[pair.first] = true;
  }
  missing_ = linked_ = alone_ = 0;
  for (size_t i = 0; i < count; ++i) {
    if (groups.registered[i]) continue;
    ++missing_;
    const size_t size = groups.members[groups.group[i]].size();
    const bool main = groups.group[i] == 0 && !models_.empty();
    if (!main && size >= kMinGroup) continue;  // A part of its own.
    ++(main || linked[i] ? linked_ : alone_);
  }
  return {};
}

Attempt Ladder::Note(const std::string& name,
                     const std::string& why,
                     const Models& models) const {
  Attempt attempt;
  attempt.name = name;
  attempt.why = why;
  attempt.models = static_cast<int>(models.size());
  if (models.empty()) return attempt;
  const Health health = MeasureHealth({models[0]}, {}, true, {});
  attempt.registered = static_cast<int>(models[0].images.size());
  attempt.points = health.num_points;
  attempt.mean_error_px = health.mean_reprojection_error_px;
  return attempt;
}

// More photos; or as many, and clearly more points that fit as well. Never at
// the price of matches that it contradicts.
StatusOr<bool> Ladder::IsBetter(const AttemptResult& result,
                                const fs::path& database) const {
  if (result.models.empty()) return false;
  if (models_.empty()) return true;
  const Attempt now = Note("", "", models_);
  const Attempt then = Note("", "", result.models);
  if (then.registered < now.registered) return false;
  if (then.registered == now.registered &&
      (then.points * 10 < now.points * 12 ||
       then.mean_error_px > 1.2 * now.mean_error_px)) {
    return false;
  }
  const auto contradictions = [](const Reconstruction& model,
                                 const fs::path& path) -> StatusOr<size_t> {
    FREEGS_ASSIGN_OR_RETURN(const MatchDatabase matches,
                            MatchDatabase::Open(path));
    FREEGS_ASSIGN_OR_RETURN(const std::vector<PairAgreement> pairs,
                            MeasureAgreement(model, matches));
    return FindContradictions(pairs).strongest.size();
  };
  FREEGS_ASSIGN_OR_RETURN(const size_t before,
                          contradictions(models_[0], database_));
  FREEGS_ASSIGN_OR_RETURN(const size_t after,
                          contradictions(result.models[0], database));
  return after <= before;
}

Status Ladder::Start(const fs::path& database, int64_t matched_pairs) {
  database_ = database;
  matched_pairs_ = matched_pairs;
  const std::string name = "mapping";
  FREEGS_ASSIGN_OR_RETURN(
      AttemptResult result, store_->Run(name, [&]() -> StatusOr<AttemptResult> {
        const fs::path scratch = store_->Folder(name) / "mapper";
        AttemptResult made;
        FREEGS_ASSIGN_OR_RETURN(made.models,
                                MapPhotos(context_, database_, scratch, {}));
        SortBySize(&made.models);
        std::error_code ignored;
        fs::remove_all(scratch, ignored);
        return made;
      }));
  models_ = std::move(result.models);
  attempts_.push_back(Note(name, "", models_));
  attempts_.back().kept = !models_.empty();
  return Look();
}

Status Ladder::Try(const Rung& rung, const std::string& why) {
  StatusOr<AttemptResult> result =
      store_->Run(rung.name, [&] { return (this->*rung.run)(rung); });
  if (!result.ok()) {
    const StatusCode code = result.status().code();
    if (code == StatusCode::kInterrupted || code == StatusCode::kInternal) {
      return result.status();
    }
    attempts_.push_back(Note(rung.name, why, {}));
    attempts_.back().problem = result.status().message();
    store_->RemoveDatabaseOf(rung.name);
    return {};
  }
  const fs::path database =
      result->has_database ? store_->Database(rung.name) : database_;
  attempts_.push_back(Note(rung.name, why, result->models));
  bool better = false;
  // The database of an attempt that was not kept is gone.
  if (!result->has_database || fs::exists(database)) {
    FREEGS_ASSIGN_OR_RETURN(better, IsBetter(*result, database));
  }
  if (!better) {
    if (result->has_database) store_->RemoveDatabaseOf(rung.name);
    return {};
  }
  attempts_.back().kept = true;
  models_ = std::move(result->models);
  if (result->has_database) {
    database_ = database;
    const auto count = static_cast<int64_t>(evidence_.photos.size());
    if (rung.run == &Ladder::MatchAllPairs) {
      matched_pairs_ = count * (count - 1) / 2;
    }
  }
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
      attempts_.push_back(Note(rung.name, why, {}));
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

StatusOr<std::vector<Reconstruction>> MapBest(const StepContext& context,
                                              const fs::path& database,
                                              const fs::path& folder) {
  FREEGS_ASSIGN_OR_RETURN(Models models,
                          MapPhotos(context, database, folder, {}));
  SortBySize(&models);
  if (NumRegistered(models) * 10 < context.input.photos.size() * 9) {
    Mapping mapping;
    mapping.step = "mapping, lower thresholds";
    mapping.relaxed = true;
    FREEGS_ASSIGN_OR_RETURN(Models relaxed,
                            MapPhotos(context, database, folder, mapping));
    SortBySize(&relaxed);
    if (NumRegistered(relaxed) > NumRegistered(models)) {
      models = std::move(relaxed);
    }
  }
  std::error_code ignored;
  fs::remove_all(folder, ignored);
  return models;
}

StatusOr<LadderResult> ClimbLadder(const StepContext& context,
                                   const fs::path& database,
                                   int64_t matched_pairs,
                                   const DiagnosisOptions& diagnosis,
                                   AttemptStore* store) {
  Ladder ladder(context, diagnosis, store);
  FREEGS_RETURN_IF_ERROR(ladder.Start(database, matched_pairs));
  FREEGS_RETURN_IF_ERROR(ladder.Climb());
  return ladder.Take();
}

}  // namespace freegs::sfm
