// SPDX-License-Identifier: BSD-3-Clause
// Runs the steps in order and leaves out those that are done.

#include "sfm/mapping/structure_from_motion.h"

#include <algorithm>
#include <iterator>
#include <memory>
#include <optional>
#include <system_error>

#include "core/number_text.h"
#include "sfm/colmap/colmap_steps.h"
#include "sfm/diagnosis/photo_reasons.h"
#include "sfm/features/point_colors.h"
#include "sfm/mapping/confirm_poses.h"
#include "sfm/mapping/initial_pair.h"
#include "sfm/mapping/map_scene.h"
#include "sfm/mapping/scene_database.h"
#include "sfm/mapping/separate_parts.h"
#include "sfm/mapping/step_record.h"
#include "sfm/matching/match_database.h"

namespace freegs::sfm {
namespace {

namespace fs = std::filesystem;

DiagnosisOptions MakeDiagnosisOptions(const SfmOptions& options) {
  DiagnosisOptions diagnosis;
  // A low limit of features is no sign of little texture.
  diagnosis.few_features =
      std::min<int64_t>(diagnosis.few_features, options.max_features / 4);
  return diagnosis;
}

// What the cameras of a model were chosen from, and why they were not.
struct CameraChoice {
  std::vector<CameraCandidate> candidates;
  std::string problem;
};

// Gives a model the simplest cameras that explain it, and adjusts it with them.
// If the model has too little to choose by, COLMAP's cameras stay.
StatusOr<CameraChoice> ChooseCameras(const StepContext& context,
                                     Reconstruction* model) {
  if (context.options.camera_model != "auto" || model->images.size() < 3) {
    return CameraChoice{};
  }
  context.Report("camera model", 0, 1, "");
  CameraSelectionOptions options;
  options.shared = context.options.camera != "per_image";
  options.per_group = options.per_photo = context.options.camera == "auto";
  options.per_photo |= context.options.camera == "per_image";
  options.num_threads = context.num_threads;
  options.cancellation = context.input.cancellation;
  auto selection = RefineCameras(options, model);
  context.Report("camera model", 1, 1, "");
  if (selection.ok()) return CameraChoice{std::move(selection->candidates), ""};
  if (selection.status().code() != StatusCode::kUnusableResult) {
    return selection.status();
  }
  return CameraChoice{{}, selection.status().message()};
}

// Tells the user which attempts beyond the first one placed more photos.
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

bool AreOfNoUse(const StepContext& context,
                const SceneEvidence& evidence,
                const std::vector<Reconstruction>& models) {
  const std::vector<Finding> findings =
      Diagnose(evidence, models, MakeDiagnosisOptions(context.options));
  return std::any_of(
      findings.begin(), findings.end(), [](const Finding& finding) {
        return finding.severity == Severity::kFatal;
      });
}

// Whether further mappings can tell something about models: the best is small
// and of use, it is as exact as the choice of cameras makes it, and there are
// two photos with which a mapping can be told to begin.
StatusOr<bool> CanMapAgain(const StepContext& context,
                           const fs::path& database,
                           const SceneEvidence& evidence,
                           const std::vector<Reconstruction>& models) {
  if (models[0].images.size() > kMostPhotosToConfirm ||
      context.options.camera_model != "auto" ||
      AreOfNoUse(context, evidence, models)) {
    return false;
  }
  FREEGS_ASSIGN_OR_RETURN(const MatchDatabase matches,
                          MatchDatabase::Open(database));
  FREEGS_ASSIGN_OR_RETURN(const std::optional<InitialPair> pair,
                          ChooseInitialPair(context.input.photos, {}, matches));
  return pair.has_value();
}

// Does all that makes a model once more, from a later pair.
StatusOr<AttemptResult> MapFromLaterPair(const StepContext& context,
                                         const fs::path& database,
                                         Mapping way,
                                         const std::string& name,
                                         std::optional<size_t> skip,
                                         AttemptStore* store) {
  way.step = "mapping, " + name;
  FREEGS_ASSIGN_OR_RETURN(
      AttemptResult made, store->Try(name, [&]() -> StatusOr<AttemptResult> {
        const fs::path folder = store->Folder(name) / "mapper";
        AttemptResult mapped;
        if (!skip) {
          FREEGS_ASSIGN_OR_RETURN(mapped.models,
                                  MapPhotos(context, database, folder, way));
          return mapped;
        }
        FREEGS_ASSIGN_OR_RETURN(
            mapped.models,
            MapFromBestPair(context, database, folder, *skip, way));
        if (!mapped.models.empty() || way.relaxed) return mapped;
        way.relaxed = true;  // Later pairs are weaker.
        FREEGS_ASSIGN_OR_RETURN(
            mapped.models,
            MapFromBestPair(context, database, folder, *skip, way));
        return mapped;
      }));
  FREEGS_ASSIGN_OR_RETURN(SeparatedParts parts,
                          SeparateParts(context,
                                        database,
                                        made.models,
                                        store,
                                        skip.value_or(0),
                                        ", " + name));
  if (!parts.models.empty()) made.models = std::move(parts.models);
  if (!made.models.empty()) {
    FREEGS_RETURN_IF_ERROR(ChooseCameras(context, &made.models[0]).status());
  }
  return made;
}

// Puts models that further mappings confirm in the place of those of the
// result, and says what was found out.
Status TakeConfirmed(const StepContext& context,
                     ConfirmedPoses confirmed,
                     SceneEvidence* evidence,
                     CameraChoice* cameras,
                     SfmResult* result) {
  if (!confirmed.models.empty()) {
    FREEGS_ASSIGN_OR_RETURN(CameraChoice their_cameras,
                            ChooseCameras(context, &confirmed.models[0]));
    if (!AreOfNoUse(context, *evidence, confirmed.models)) {
      result->models = std::move(confirmed.models);
      *cameras = std::move(their_cameras);
    } else {
      // A model with uncertain photos is better than none.
      confirmed.replaced = false;
      for (Attempt& attempt : confirmed.attempts) {
        if (attempt.kept) attempt.problem = "its poses cannot be trusted";
        attempt.kept = false;
      }
    }
  }
  if (confirmed.replaced) {
    result->warnings.push_back(
        "mapping from other photos put some elsewhere; the model is taken of "
        "whose photos most are where other models have them");
    std::erase_if(evidence->unplaced, [&](const std::string& name) {
      const std::vector<PosedImage>& images = result->models[0].images;
      return std::any_of(images.begin(), images.end(), [&](const auto& image) {
        return image.name == name;
      });
    });
  }
  if (!confirmed.attempts.empty() && !confirmed.witnessed) {
    result->warnings.push_back(
        "mapping from other photos did not lead to the same poses; look at the "
        "cameras before you trust them");
  }
  evidence->uncertain = std::move(confirmed.uncertain);
  std::move(confirmed.attempts.begin(),
            confirmed.attempts.end(),
            std::back_inserter(result->attempts));
  return {};
}

// Gives the best model its cameras. Replaces the models if further mappings put
// its photos elsewhere.
Status RefineAndConfirm(const StepContext& context,
                        const fs::path& database,
                        const Mapping& way,
                        AttemptStore* store,
                        SceneEvidence* evidence,
                        SfmResult* result) {
  if (result->models.empty()) return {};
  FREEGS_ASSIGN_OR_RETURN(CameraChoice cameras,
                          ChooseCameras(context, &result->models[0]));
  FREEGS_ASSIGN_OR_RETURN(
      const bool can,
      CanMapAgain(context, database, *evidence, result->models));
  if (can) {
    const auto map_again = [&](const std::string& name,
                               std::optional<size_t> skip) {
      return MapFromLaterPair(context, database, way, name, skip, store);
    };
    const size_t half = (context.input.photos.size() + 1) / 2;
    FREEGS_ASSIGN_OR_RETURN(ConfirmedPoses confirmed,
                            ConfirmPoses(result->models, half, map_again));
    FREEGS_RETURN_IF_ERROR(TakeConfirmed(
        context, std::move(confirmed), evidence, &cameras, result));
  }
  if (!cameras.problem.empty()) {
    result->warnings.push_back("COLMAP's RADIAL cameras are kept: " +
                               cameras.problem);
  }
  result->camera_models = std::move(cameras.candidates);
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
  const DiagnosisOptions diagnosis = MakeDiagnosisOptions(options);
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
  FREEGS_RETURN_IF_ERROR(RefineAndConfirm(
      context, database, scene.way, &store, &scene.evidence, &result));
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
  // First of all: without it, a run that is killed here starts again.
  fs::remove(work_folder / "steps.json", ignored);
  AttemptStore::Remove(work_folder);
}

}  // namespace freegs::sfm
