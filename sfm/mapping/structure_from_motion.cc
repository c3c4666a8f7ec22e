// SPDX-License-Identifier: BSD-3-Clause
// Runs the steps in order and leaves out those that are done.

#include "sfm/mapping/structure_from_motion.h"

#include <algorithm>
#include <iterator>
#include <memory>
#include <system_error>

#include "core/number_text.h"
#include "sfm/colmap/colmap_steps.h"
#include "sfm/diagnosis/photo_reasons.h"
#include "sfm/features/point_colors.h"
#include "sfm/mapping/map_scene.h"
#include "sfm/mapping/model_refinement.h"
#include "sfm/mapping/scene_database.h"
#include "sfm/mapping/separate_parts.h"
#include "sfm/mapping/step_record.h"

namespace freegs::sfm {
namespace {

namespace fs = std::filesystem;

// Tells the user which attempts after the plain one placed more photos. There
// is no plain one where a part of the photos was mapped first and did.
void WarnOfAttempts(const std::vector<Attempt>& attempts,
                    size_t photos,
                    std::vector<std::string>* warnings) {
  const auto plain = std::find_if(
      attempts.begin(), attempts.end(), [](const Attempt& attempt) {
        return attempt.name == kPlainMapping;
      });
  if (plain == attempts.end()) return;
  std::string kept;
  int registered = plain->registered;
  for (auto attempt = plain + 1; attempt != attempts.end(); ++attempt) {
    if (!attempt->kept || attempt->registered <= registered) continue;
    registered = attempt->registered;
    kept += (kept.empty() ? "" : ", ") + attempt->name;
  }
  if (kept.empty()) return;
  warnings->push_back("the usual way registered only " +
                      std::to_string(plain->registered) + " of " +
                      std::to_string(photos) + " photos; what helped: " + kept);
}

// Replaces the models if the best one turns out to consist of glued parts.
Status TakeSeparated(const StepContext& context,
                     const fs::path& database,
                     AttemptStore* store,
                     SceneEvidence* evidence,
                     SfmResult* result) {
  FREEGS_ASSIGN_OR_RETURN(
      SeparatedParts parts,
      SeparateParts(context, database, result->models, store));
  if (parts.models.empty()) return {};
  result->models = std::move(parts.models);
  std::move(parts.attempts.begin(),
            parts.attempts.end(),
            std::back_inserter(result->attempts));
  result->warnings.push_back(
      "parts of the scene look alike: a first model had glued " +
      std::to_string(parts.groups) +
      " groups of photos, of the evidence between which only a share of " +
      FormatFixed(parts.score, 2) + " supported it");
  evidence->unplaced = std::move(parts.unplaced);
  return {};
}

// Takes the models with their cameras, and what was found out about them.
Status TakeRefined(const StepContext& context,
                   const fs::path& database,
                   const MapperOptions& options,
                   const DiagnosisOptions& diagnosis,
                   AttemptStore* store,
                   SceneEvidence* evidence,
                   SfmResult* result) {
  ModelRefinement refinement(context, database, options, diagnosis, store);
  FREEGS_ASSIGN_OR_RETURN(RefinedModels refined,
                          refinement.Run(std::move(result->models), evidence));
  result->models = std::move(refined.models);
  result->camera_models = std::move(refined.camera_models);
  std::move(refined.attempts.begin(),
            refined.attempts.end(),
            std::back_inserter(result->attempts));
  std::move(refined.warnings.begin(),
            refined.warnings.end(),
            std::back_inserter(result->warnings));
  return {};
}

}  // namespace

StatusOr<SfmResult> RunStructureFromMotion(const SfmInput& input,
                                           const SfmOptions& options) {
  FREEGS_ASSIGN_OR_RETURN(const std::unique_ptr<SceneDatabase> scene_database,
                          SceneDatabase::Build(input, options));
  const StepContext& context = scene_database->context();
  const fs::path& database = scene_database->path();
  StepRecord& record = scene_database->record();

  SfmResult result;
  result.colmap_version = context.colmap.version();
  result.warnings = context.colmap.KnownFaults();
  DiagnosisOptions diagnosis;
  // A low limit of features is no sign of little texture.
  diagnosis.few_features =
      std::min<int64_t>(diagnosis.few_features, options.max_features / 4);
  AttemptStore store(input.work_folder, &record);
  FREEGS_ASSIGN_OR_RETURN(MappedScene scene,
                          MapScene(context, database, diagnosis, &store));
  WarnOfAttempts(scene.attempts, input.photos.size(), &result.warnings);

  result.models = std::move(scene.models);
  result.pairs = record.pairs();
  result.image_size = context.options.max_image_size;
  result.max_features = context.options.max_features;
  result.attempts = std::move(scene.attempts);
  FREEGS_RETURN_IF_ERROR(
      TakeSeparated(context, database, &store, &scene.evidence, &result));
  FREEGS_RETURN_IF_ERROR(TakeRefined(context,
                                     database,
                                     scene.options,
                                     diagnosis,
                                     &store,
                                     &scene.evidence,
                                     &result));
  for (Reconstruction& model : result.models) {
    FREEGS_RETURN_IF_ERROR(ColorPoints(input, context.num_threads, &model));
  }
  result.findings = Diagnose(scene.evidence, result.models, diagnosis);
  result.unregistered =
      ExplainUnregistered(scene.evidence, result.models, diagnosis);
  return result;
}

void TidyWorkFolder(const fs::path& work_folder) {
  std::error_code ignored;
  // steps.json is removed first, so that a run killed here begins anew instead
  // of trusting steps whose files are gone.
  fs::remove(work_folder / "steps.json", ignored);
  AttemptStore::Remove(work_folder);
}

}  // namespace freegs::sfm
