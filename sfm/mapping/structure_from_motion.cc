// SPDX-License-Identifier: BSD-3-Clause
// Runs the steps in order and leaves out those that are done.

#include "sfm/mapping/structure_from_motion.h"

#include <algorithm>
#include <iterator>
#include <system_error>
#include <thread>

#include "core/io/files.h"
#include "core/number_text.h"
#include "sfm/colmap/colmap_program.h"
#include "sfm/colmap/colmap_steps.h"
#include "sfm/diagnosis/photo_reasons.h"
#include "sfm/features/extract_features.h"
#include "sfm/features/image_size.h"
#include "sfm/features/point_colors.h"
#include "sfm/mapping/map_scene.h"
#include "sfm/mapping/separate_parts.h"
#include "sfm/mapping/step_record.h"
#include "sfm/matching/match_database.h"

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

// Fills the database with photos, features and matches.
Status BuildDatabase(const StepContext& context,
                     const fs::path& database,
                     StepRecord* record) {
  if (!record->Has("photos")) {
    RemoveDatabase(database);
    FREEGS_RETURN_IF_ERROR(RegisterPhotos(context, database));
    FREEGS_RETURN_IF_ERROR(record->Add("photos"));
  }
  if (!record->Has("features")) {
    FREEGS_RETURN_IF_ERROR(ExtractFeatures(context, database));
    FREEGS_RETURN_IF_ERROR(record->Add("features"));
  }
  if (!record->Has("matches")) {
    FREEGS_ASSIGN_OR_RETURN(
        const MatchedPairs pairs,
        MatchFeatures(context, database, record->portions(), [&](int portion) {
          return record->AddPortion(portion);
        }));
    FREEGS_RETURN_IF_ERROR(record->AddMatches(pairs));
  }
  return {};
}

// Gives the best model the simplest cameras that explain it, and adjusts it
// with them. If the model has too little to choose by, COLMAP's cameras stay.
Status ChooseCameras(const StepContext& context, SfmResult* result) {
  if (context.options.camera_model != "auto" || result->models.empty() ||
      result->models[0].images.size() < 3) {
    return {};
  }
  context.Report("camera model", 0, 1, "");
  CameraSelectionOptions options;
  options.shared = context.options.camera != "per_image";
  options.per_group = options.per_photo = context.options.camera == "auto";
  options.per_photo |= context.options.camera == "per_image";
  options.num_threads = context.num_threads;
  options.cancellation = context.input.cancellation;
  auto selection = RefineCameras(options, &result->models[0]);
  context.Report("camera model", 1, 1, "");
  if (selection.ok()) {
    result->camera_models = std::move(selection->candidates);
    return {};
  }
  if (selection.status().code() != StatusCode::kUnusableResult) {
    return selection.status();
  }
  result->warnings.push_back("COLMAP's RADIAL cameras are kept: " +
                             selection.status().message());
  return {};
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

}  // namespace

StatusOr<SfmResult> RunStructureFromMotion(const SfmInput& input,
                                           const SfmOptions& options) {
  FREEGS_RETURN_IF_ERROR(options.Check());
  FREEGS_RETURN_IF_ERROR(CheckNames(input));
  FREEGS_ASSIGN_OR_RETURN(
      ColmapProgram colmap,
      ColmapProgram::Find(options.colmap, input.cancellation));
  FREEGS_RETURN_IF_ERROR(CreateFolders(input.work_folder / "logs"));

  SfmOptions resolved = options;
  StepContext context{input, resolved, colmap};
  context.num_threads =
      options.num_threads > 0
          ? options.num_threads
          : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  const fs::path database = input.work_folder / "database.db";
  StepRecord record(input.work_folder);
  if (options.max_image_size == 0) {
    if (!record.Has("features") || record.image_size() < 64) {
      FREEGS_ASSIGN_OR_RETURN(const int size, ChooseImageSize(context));
      FREEGS_RETURN_IF_ERROR(record.SetImageSize(size));
    }
    resolved.max_image_size = record.image_size();
  }
  FREEGS_RETURN_IF_ERROR(BuildDatabase(context, database, &record));

  SfmResult result;
  result.colmap_version = colmap.version();
  result.warnings = colmap.KnownFaults();
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
  result.image_size = resolved.max_image_size;
  result.attempts = std::move(scene.attempts);
  FREEGS_RETURN_IF_ERROR(
      TakeSeparated(context, database, &store, &scene.evidence, &result));
  FREEGS_RETURN_IF_ERROR(ChooseCameras(context, &result));
  for (Reconstruction& model : result.models) {
    FREEGS_RETURN_IF_ERROR(ColorPoints(context, &model));
  }
  result.findings = Diagnose(scene.evidence, result.models, diagnosis);
  result.unregistered =
      ExplainUnregistered(scene.evidence, result.models, diagnosis);
  std::error_code ignored;
  fs::remove(input.work_folder / "image_list.txt", ignored);
  return result;
}

void TidyWorkFolder(const fs::path& work_folder) {
  std::error_code ignored;
  // First of all: without it, a run that is killed here starts again.
  fs::remove(work_folder / "steps.json", ignored);
  AttemptStore::Remove(work_folder);
}

}  // namespace freegs::sfm
