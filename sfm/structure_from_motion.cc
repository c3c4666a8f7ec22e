// SPDX-License-Identifier: BSD-3-Clause
// The order of the steps, and which of them are done.

#include "sfm/structure_from_motion.h"

#include <algorithm>
#include <cstdio>
#include <system_error>
#include <thread>

#include "core/files.h"
#include "sfm/colmap_program.h"
#include "sfm/colmap_steps.h"
#include "sfm/ladder.h"
#include "sfm/match_database.h"
#include "sfm/reconcile.h"
#include "sfm/separate_parts.h"
#include "sfm/step_record.h"
#include "sfm/view_graph.h"

namespace freegs::sfm {
namespace {

namespace fs = std::filesystem;

Status CheckNames(const SfmInput& input) {
  for (const SfmPhoto& photo : input.photos) {
    const std::string& name = photo.name;
    if (name.empty() || name.find_first_of("\r\n") != std::string::npos ||
        name.front() == ' ' || name.back() == ' ') {
      return BadInputError("photo '" + name +
                           "': COLMAP cannot read a name that begins or ends "
                           "with a space or has a line break; rename it");
    }
  }
  return {};
}

// Features and matches into work_folder/database.db.
Status BuildDatabase(const StepContext& context,
                     const fs::path& database,
                     StepRecord* record) {
  if (!record->Has("photos")) {
    RemoveDatabase(database);
    FREEGS_ASSIGN_OR_RETURN(const bool numbered,
                            RegisterPhotos(context, database));
    if (!numbered) FREEGS_RETURN_IF_ERROR(record->Add("one extractor thread"));
    FREEGS_RETURN_IF_ERROR(record->Add("photos"));
  }
  if (!record->Has("features")) {
    // Photos that have their features already are skipped by COLMAP, which
    // writes each photo's in one transaction.
    FREEGS_RETURN_IF_ERROR(ExtractFeatures(
        context,
        database,
        record->Has("one extractor thread") ? 1 : context.num_threads));
    FREEGS_RETURN_IF_ERROR(record->Add("features"));
  }
  if (!record->Has("matches")) {
    FREEGS_RETURN_IF_ERROR(
        MatchFeatures(context, database, record->portions(), [&](int portion) {
          return record->AddPortion(portion);
        }));
    FREEGS_RETURN_IF_ERROR(record->Add("matches"));
  }
  return {};
}

// How many pairs of photos SelectPairs gave to the matcher.
StatusOr<int64_t> CountMatchedPairs(const fs::path& path,
                                    const SfmOptions& options) {
  FREEGS_ASSIGN_OR_RETURN(const MatchDatabase database,
                          MatchDatabase::Open(path));
  FREEGS_ASSIGN_OR_RETURN(const auto photos, database.Photos());
  const auto usable =
      std::count_if(photos.begin(), photos.end(), [](const auto& photo) {
        return photo.num_features > 0;
      });
  return static_cast<int64_t>(
      SelectPairs(static_cast<int>(usable), options).size());
}

// What the attempts beyond the first changed, for people.
void WarnOfAttempts(const std::vector<Attempt>& attempts,
                    size_t photos,
                    std::vector<std::string>* warnings) {
  std::string kept;
  int registered = attempts[0].registered;
  for (size_t i = 1; i < attempts.size(); ++i) {
    if (!attempts[i].kept || attempts[i].registered <= registered) continue;
    registered = attempts[i].registered;
    kept += (kept.empty() ? "" : ", ") + attempts[i].name;
  }
  if (kept.empty()) return;
  warnings->push_back("the usual way registered only " +
                      std::to_string(attempts[0].registered) + " of " +
                      std::to_string(photos) + " photos; what helped: " + kept);
}

// Replaces a model that turns out to be glued parts.
Status TakeSeparated(const StepContext& context,
                     int64_t matched_pairs,
                     AttemptStore* store,
                     SceneEvidence* evidence,
                     SfmResult* result) {
  FREEGS_ASSIGN_OR_RETURN(SeparatedParts parts,
                          SeparateParts(context,
                                        result->database,
                                        evidence->all_pairs_compared(),
                                        result->models,
                                        store));
  if (parts.models.empty()) return {};
  result->models = std::move(parts.models);
  for (Attempt& attempt : parts.attempts) {
    result->attempts.push_back(std::move(attempt));
  }
  char score[16];
  std::snprintf(score, sizeof(score), "%.2f", parts.score);
  result->warnings.push_back(
      "parts of the scene look alike: a first model had glued " +
      std::to_string(parts.groups) +
      " groups of photos, of the evidence between which only a share of " +
      score + " supported it");
  FREEGS_ASSIGN_OR_RETURN(const MatchDatabase database,
                          MatchDatabase::Open(parts.database));
  if (result->database != parts.database) {
    result->database = parts.database;
    FREEGS_ASSIGN_OR_RETURN(
        *evidence,
        CollectEvidence(context.input.photos, database, matched_pairs));
  }
  evidence->unplaced = std::move(parts.unplaced);
  // Where look-alikes glue a model they are among the strongest matches: that a
  // model contradicts some of these is then nothing against it, if all matches
  // taken together are for it.
  if (parts.one) {
    result->contradictions = 0;
    return {};
  }
  FREEGS_ASSIGN_OR_RETURN(const std::vector<PairAgreement> pairs,
                          MeasureAgreement(result->models[0], database));
  result->contradictions = FindContradictions(pairs).strongest.size();
  return {};
}

}  // namespace

Status SfmOptions::Check() const {
  if (camera != "auto" && camera != "single" && camera != "per_image") {
    return InvalidArgumentError("sfm.camera must be auto, single or per_image");
  }
  if (FindCameraModel(std::string_view(camera_model)) == nullptr) {
    std::string names;
    for (const CameraModelInfo& model : CameraModels()) {
      names += (names.empty() ? "" : ", ") + std::string(model.name);
    }
    return InvalidArgumentError("sfm.camera_model must be one of " + names);
  }
  if (matcher != "auto" && matcher != "exhaustive" && matcher != "sequential") {
    return InvalidArgumentError(
        "sfm.matcher must be auto, exhaustive or sequential");
  }
  if (!(max_retry_cost >= 0)) {
    return InvalidArgumentError("sfm.max_retry_cost must be at least 0");
  }
  if (max_image_size < 64 || max_features < 64 || overlap < 1 ||
      max_exhaustive < 0) {
    return InvalidArgumentError(
        "sfm.max_image_size and sfm.max_features must be at least 64, "
        "sfm.overlap at least 1 and sfm.max_exhaustive at least 0");
  }
  return {};
}

void SortBySize(std::vector<Reconstruction>* models) {
  std::stable_sort(models->begin(),
                   models->end(),
                   [](const Reconstruction& a, const Reconstruction& b) {
                     return std::pair(a.images.size(), a.points3d.size()) >
                            std::pair(b.images.size(), b.points3d.size());
                   });
}

StatusOr<SfmResult> RunStructureFromMotion(const SfmInput& input,
                                           const SfmOptions& options) {
  FREEGS_RETURN_IF_ERROR(options.Check());
  FREEGS_RETURN_IF_ERROR(CheckNames(input));
  FREEGS_ASSIGN_OR_RETURN(
      ColmapProgram colmap,
      ColmapProgram::Find(options.colmap, input.cancellation));
  FREEGS_RETURN_IF_ERROR(CreateFolders(input.work_folder / "logs"));

  StepContext context{input, options, colmap};
  context.num_threads =
      options.num_threads > 0
          ? options.num_threads
          : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  const fs::path database = input.work_folder / "database.db";
  StepRecord record(input.work_folder);
  FREEGS_RETURN_IF_ERROR(BuildDatabase(context, database, &record));

  SfmResult result;
  result.colmap_version = colmap.version();
  if (record.Has("one extractor thread")) {
    result.warnings.push_back(
        "this COLMAP has no database_cleaner: features were taken by one "
        "thread, to stay repeatable");
  }
  DiagnosisOptions diagnosis;
  // A low limit of features is no sign of little texture.
  diagnosis.few_features =
      std::min<int64_t>(diagnosis.few_features, options.max_features / 4);
  FREEGS_ASSIGN_OR_RETURN(const int64_t pairs,
                          CountMatchedPairs(database, options));
  AttemptStore store(input.work_folder, &record);
  FREEGS_ASSIGN_OR_RETURN(
      LadderResult best,
      ClimbLadder(context, database, pairs, diagnosis, &store));
  WarnOfAttempts(best.attempts, input.photos.size(), &result.warnings);

  FREEGS_ASSIGN_OR_RETURN(
      Reconciled reconciled,
      Reconcile(context, best.database, best.models, &store));
  if (reconciled.before > 0) {
    result.warnings.push_back(
        "parts of the scene look alike: a first model contradicted " +
        std::to_string(reconciled.before) +
        " of the strongest matches; mapped again without " +
        std::to_string(reconciled.removed) + " matching pairs, which leaves " +
        std::to_string(reconciled.contradictions) + " contradicted");
    best.attempts.push_back(DescribeAttempt(
        "without look-alikes",
        "the model contradicts " + std::to_string(reconciled.before) +
            " of the strongest matches",
        reconciled.models));
    best.attempts.back().kept = !reconciled.models.empty();
  }
  result.models =
      std::move(reconciled.models.empty() ? best.models : reconciled.models);
  result.database = std::move(best.database);
  result.attempts = std::move(best.attempts);
  result.contradictions = reconciled.contradictions;
  FREEGS_RETURN_IF_ERROR(
      TakeSeparated(context, pairs, &store, &best.evidence, &result));
  best.evidence.contradictions = result.contradictions;
  result.findings = Diagnose(best.evidence, result.models, diagnosis);
  result.unregistered =
      ExplainUnregistered(best.evidence, result.models, diagnosis);
  std::error_code ignored;
  fs::remove(input.work_folder / "image_list.txt", ignored);
  return result;
}

Status TidyWorkFolder(const fs::path& work_folder, const SfmResult& result) {
  std::error_code error;
  // First of all: without it, a run that is killed here starts again.
  fs::remove(work_folder / "steps.json", error);
  const fs::path database = work_folder / "database.db";
  if (result.database != database) {
    RemoveDatabase(database);
    fs::rename(result.database, database, error);
    if (error) {
      return InternalError(result.database.string() +
                           ": cannot be moved: " + error.message());
    }
  }
  AttemptStore::Remove(work_folder);
  return {};
}

}  // namespace freegs::sfm
