// SPDX-License-Identifier: BSD-3-Clause

#include "stages/sfm/sfm_stage.h"

#include <algorithm>
#include <array>
#include <set>
#include <system_error>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/io/files.h"
#include "core/io/json_text.h"
#include "core/text.h"
#include "photos/photo_list.h"
#include "sfm/features/point_colors.h"
#include "sfm/import/import_model.h"
#include "sfm/mapping/known_poses.h"
#include "sfm/scene/model_io.h"
#include "sfm/scene/scene_frame.h"
#include "stages/sfm/photo_masks.h"
#include "stages/sfm/sfm_forecast.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;
using pipeline::LogLevel;
using pipeline::StageContext;

// Start points of an import that has none, if none can be triangulated.
constexpr int kRandomPoints = 10000;

// Fewer points than these say little of a scene.
constexpr size_t kMinTriangulated = 100;

std::vector<sfm::SfmPhoto> UsablePhotos(const photos::PhotoList& list) {
  std::vector<sfm::SfmPhoto> photos;
  for (const photos::Photo& photo : list.photos) {
    if (!photo.usable()) continue;
    photos.push_back({.name = photo.name,
                      .file = photo.file,
                      .width = photo.width,
                      .height = photo.height,
                      .camera_group = photo.camera_group,
                      .focal_px = photo.focal_length_px.value_or(0),
                      .sharpness = photo.sharpness,
                      .orientation = photo.orientation});
  }
  return photos;
}

// The last component of a path: "right" of "rig/right/". Empty if there is
// none.
std::string FolderName(const std::string& path) {
  const fs::path plain = fs::path(path + "/").lexically_normal().parent_path();
  return plain.filename().string();
}

// Programs that do not look for colours leave all points black.
bool HasNoColors(const sfm::Reconstruction& model) {
  constexpr std::array<uint8_t, 3> kBlack = {0, 0, 0};
  if (model.points3d.empty()) return false;
  return std::all_of(model.points3d.begin(),
                     model.points3d.end(),
                     [&](const auto& point) { return point.rgb == kBlack; });
}

// Makes all points as grey as random ones, because a training can hardly leave
// black.
void MakeGrey(sfm::Reconstruction* model) {
  for (sfm::Point3D& point : model->points3d) point.rgb = {128, 128, 128};
}

// The poses, from COLMAP or from an import.
struct Outcome {
  std::string source;
  bool triangulated = true;
  bool imported = false;
  sfm::SfmResult result;  // An import has only a model and warnings.
};

class SfmStage : public pipeline::Stage {
 public:
  SfmStage(const SfmStageOptions& options, uint64_t seed)
      : options_(options), seed_(seed) {}

  std::string_view name() const override { return "sfm"; }
  int version() const override { return 11; }

  std::vector<fs::path> Inputs(const StageContext& context) const override {
    std::vector<fs::path> inputs = {"ingest/images.json", "ingest/photos"};
    if (HasMasks(context)) inputs.emplace_back("ingest/masks");
    if (options_.import.empty()) return inputs;
    const auto source = sfm::FindImportSource(options_.import);
    if (!source.ok()) {
      inputs.emplace_back(options_.import);
      return inputs;
    }
    for (const fs::path& file : source->Files()) inputs.push_back(file);
    return inputs;
  }

  std::vector<std::string> Disposable() const override {
    return {"database.db", "logs"};
  }

  pipeline::StageNeed Foretell(const StageContext& context,
                               bool done,
                               pipeline::SceneOutlook* scene) const override {
    pipeline::StageNeed need =
        SfmNeed(options_.colmap, context.pool->num_threads(), scene);
    if (!options_.import.empty()) {
      need = {.unknown_reason = "nothing is known of a model that is imported"};
    }
    if (done)
      SetSceneToModel(context.workspace / "sfm" / "sparse" / "0", scene);
    return need;
  }

  Status Run(StageContext& context) override {
    FREEGS_RETURN_IF_ERROR(options_.health.Check());
    FREEGS_ASSIGN_OR_RETURN(
        const photos::PhotoList list,
        photos::ReadPhotoList(context.workspace / "ingest" / "images.json"));
    const std::vector<sfm::SfmPhoto> photos = UsablePhotos(list);
    StatusOr<Outcome> outcome = options_.import.empty()
                                    ? RunColmap(photos, context)
                                    : Import(photos, list, context);
    if (!outcome.ok()) return outcome.status();
    return Finish(photos, *outcome, context);
  }

 private:
  sfm::SfmInput InputOf(const std::vector<sfm::SfmPhoto>& photos,
                        const StageContext& context) const {
    sfm::SfmInput input;
    input.photo_folder = context.workspace / "ingest" / "photos";
    input.photos = photos;
    if (HasMasks(context)) {
      input.mask_folder = context.workspace / "ingest" / "masks";
    }
    input.work_folder = context.output;
    input.seed = seed_;
    input.cancellation = context.cancellation;
    input.progress = context.progress;
    return input;
  }

  sfm::SfmOptions ColmapOptions(const StageContext& context) const {
    sfm::SfmOptions options = options_.colmap;
    options.num_threads = context.pool->num_threads();
    return options;
  }

  StatusOr<Outcome> RunColmap(const std::vector<sfm::SfmPhoto>& photos,
                              StageContext& context) const {
    Outcome outcome;
    outcome.source = "colmap";
    FREEGS_ASSIGN_OR_RETURN(
        outcome.result,
        sfm::RunStructureFromMotion(InputOf(photos, context),
                                    ColmapOptions(context)));
    return outcome;
  }

  StatusOr<Outcome> Import(const std::vector<sfm::SfmPhoto>& photos,
                           const photos::PhotoList& list,
                           StageContext& context) const {
    FREEGS_ASSIGN_OR_RETURN(const sfm::ImportSource source,
                            sfm::FindImportSource(options_.import));
    FREEGS_ASSIGN_OR_RETURN(
        sfm::ImportedModel imported,
        sfm::ImportModel(source,
                         photos,
                         {options_.random_points > 0 ? options_.random_points
                                                     : kRandomPoints,
                          seed_,
                          FolderName(list.images_folder)}));
    Outcome outcome;
    outcome.imported = true;
    outcome.source = source.colmap_model.empty() ? "imported transforms.json"
                                                 : "imported COLMAP model";
    std::vector<std::string>& warnings = outcome.result.warnings;
    warnings = std::move(imported.warnings);
    if (imported.random_points && options_.random_points == 0) {
      FREEGS_RETURN_IF_ERROR(Triangulate(photos, context, &imported, &outcome));
    }
    if (HasNoColors(imported.model)) {
      FREEGS_RETURN_IF_ERROR(sfm::ColorPoints(InputOf(photos, context),
                                              context.pool->num_threads(),
                                              &imported.model));
      // Points without tracks get no colours from the photos.
      if (HasNoColors(imported.model)) {
        MakeGrey(&imported.model);
        warnings.push_back(
            "the imported points have no colours (all are black), and their "
            "tracks lead to none in the photos; they are made grey");
      }
    }
    outcome.triangulated = false;
    if (imported.random_points) {
      outcome.source += ", points random";
    } else {
      for (const sfm::Point3D& point : imported.model.points3d) {
        if (point.track.size() >= 2) outcome.triangulated = true;
      }
    }
    if (!imported.unmatched.empty()) {
      warnings.push_back(
          std::to_string(imported.unmatched.size()) +
          " imported poses fit no photo: " + SomeNames(imported.unmatched));
    }
    if (!imported.turned.empty()) {
      warnings.push_back(
          "EXIF turns these photos, and their sizes cannot show whether the "
          "imported poses belong to the turned photos, as they must; if the "
          "scene looks wrong, make the poses of upright photos: " +
          SomeNames(imported.turned));
    }
    if (imported.names_masks && !HasMasks(context)) {
      warnings.push_back(
          "the imported file names masks (mask_path), which are not used; give "
          "their folder with --ingest.masks");
    }
    WarnOfHoldout(imported.holdout, list, &warnings);
    context.summary["imported_holdout"] = imported.holdout;
    outcome.result.models.push_back(std::move(imported.model));
    return outcome;
  }

  // Replaces the random points of a model by those that the photos show, if
  // there are enough of them; otherwise says why not.
  Status Triangulate(const std::vector<sfm::SfmPhoto>& photos,
                     StageContext& context,
                     sfm::ImportedModel* imported,
                     Outcome* outcome) const {
    std::vector<std::string>& warnings = outcome->result.warnings;
    const std::string instead = "; the points to start from are random ones";
    auto scene = sfm::TriangulateScene(
        InputOf(photos, context), ColmapOptions(context), imported->model);
    const StatusCode code = scene.status().code();
    if (code == StatusCode::kMissingDependency ||
        code == StatusCode::kUnusableResult) {
      warnings.push_back("no points were triangulated from the imported poses" +
                         instead + ": " + scene.status().message());
      return {};
    }
    if (!scene.ok()) return scene.status();
    warnings.insert(
        warnings.end(), scene->warnings.begin(), scene->warnings.end());
    outcome->result.findings = std::move(scene->findings);
    outcome->result.pairs = std::move(scene->pairs);
    outcome->result.image_size = scene->image_size;
    outcome->result.max_features = scene->max_features;
    outcome->result.colmap_version = std::move(scene->colmap_version);
    const size_t points = scene->model.points3d.size();
    if (points < kMinTriangulated) {
      warnings.push_back("from the imported poses only " +
                         std::to_string(points) +
                         " points could be triangulated" + instead +
                         " (either the poses do not fit the photos, or these "
                         "show little texture)");
      return {};
    }
    outcome->source += ", points triangulated";
    imported->model = std::move(scene->model);
    imported->random_points = false;
    return {};
  }

  // Stage ingest decides which photos are holdout. Warns when the import names
  // others.
  static void WarnOfHoldout(const std::vector<std::string>& holdout,
                            const photos::PhotoList& list,
                            std::vector<std::string>* warnings) {
    if (holdout.empty()) return;
    const std::set<std::string> wanted(holdout.begin(), holdout.end());
    std::vector<std::string> differing;
    for (const photos::Photo& photo : list.photos) {
      if (photo.usable() && (photo.split == photos::PhotoSplit::kHoldout) !=
                                wanted.contains(photo.name)) {
        differing.push_back(photo.name);
      }
    }
    if (differing.empty()) return;
    warnings->push_back(
        "the import names other holdout photos (transforms_test.json, "
        "transforms_val.json, test_filenames, val_filenames) than ingest "
        "chose; choose them with the ingest.holdout options (differing: " +
        SomeNames(differing) + ")");
  }

  Status Finish(const std::vector<sfm::SfmPhoto>& photos,
                const Outcome& outcome,
                StageContext& context) const {
    std::vector<std::string> names;
    for (const sfm::SfmPhoto& photo : photos) names.push_back(photo.name);
    const sfm::SfmResult& result = outcome.result;
    const sfm::MappingFacts facts = {
        .imported = outcome.imported,
        .max_features = result.max_features,
        .all_pairs_compared = result.pairs.pairs == result.pairs.all_pairs,
        .camera = options_.colmap.camera,
        .camera_model = options_.colmap.camera_model};
    sfm::Health health = sfm::MeasureHealth(result.models,
                                            names,
                                            outcome.triangulated,
                                            options_.health,
                                            facts,
                                            result.findings);
    health.source = outcome.source;
    health.attempts = result.attempts;
    health.colmap_version = result.colmap_version;
    health.camera_models = result.camera_models;
    health.pairs = result.pairs;
    health.image_size = result.image_size;
    for (auto& [name, reason] : health.unregistered) {
      const auto it = result.unregistered.find(name);
      if (it != result.unregistered.end()) reason = it->second;
    }
    health.warnings.insert(
        health.warnings.end(), result.warnings.begin(), result.warnings.end());

    const fs::path sparse = context.output / "sparse";
    std::error_code error;
    fs::remove_all(sparse, error);
    for (size_t i = 0; i < result.models.size(); ++i) {
      FREEGS_RETURN_IF_ERROR(
          sfm::WriteModel(sparse / std::to_string(i), result.models[i]));
    }
    if (!result.models.empty()) {
      FREEGS_ASSIGN_OR_RETURN(const sfm::SceneFrame frame,
                              sfm::EstimateSceneFrame(result.models[0]));
      FREEGS_RETURN_IF_ERROR(
          WriteFileAtomic(context.output / "frame.json",
                          JsonText(sfm::SceneFrameToJson(frame))));
    }
    const nlohmann::json json = sfm::HealthToJson(health);
    FREEGS_RETURN_IF_ERROR(
        WriteFileAtomic(context.output / "health.json", JsonText(json)));
    for (const char* key : {"verdict",
                            "images",
                            "registered",
                            "models",
                            "mean_reprojection_error_px",
                            "num_points",
                            "warnings",
                            "pairs",
                            "source",
                            "colmap_version"}) {
      context.summary[key] = json[key];
    }
    FREEGS_RETURN_IF_ERROR(Report(health, context));
    sfm::TidyWorkFolder(context.output);
    return {};
  }

  Status Report(const sfm::Health& health, StageContext& context) const {
    for (const std::string& warning : health.warnings) {
      context.log(LogLevel::kWarning, warning);
    }
    if (!health.pairs.strategy.empty()) {
      context.log(LogLevel::kInfo,
                  "matched " + std::to_string(health.pairs.pairs) + " of " +
                      std::to_string(health.pairs.all_pairs) +
                      " pairs of photos (" + health.pairs.strategy +
                      "), by up to " + std::to_string(health.max_features) +
                      " features of each");
    }
    std::vector<std::string> missing;
    for (const auto& entry : health.unregistered)
      missing.push_back(entry.first);
    if (!missing.empty()) {
      context.log(LogLevel::kWarning,
                  std::to_string(missing.size()) +
                      (missing.size() == 1
                           ? " photo has no pose and is left out: "
                           : " photos have no pose and are left out: ") +
                      SomeNames(missing));
    }
    if (health.verdict == sfm::Verdict::kFailed) {
      std::error_code error;
      const bool has_logs = fs::is_directory(context.output / "logs", error);
      return UnusableResultError(
          health.reason + ". What to try: " + health.advice +
          ". See health.json" + (has_logs ? " and logs/" : "") + " in " +
          context.output.string());
    }
    if (health.verdict == sfm::Verdict::kDegraded) {
      context.log(LogLevel::kWarning,
                  "degraded: " + health.reason + "; " + health.advice);
    }
    context.log(LogLevel::kInfo,
                std::to_string(health.registered) + " of " +
                    std::to_string(health.images) + " photos, " +
                    std::to_string(health.measures.num_points) + " points (" +
                    health.source + ")");
    return {};
  }

  SfmStageOptions options_;
  uint64_t seed_;
};

}  // namespace

std::unique_ptr<pipeline::Stage> MakeSfmStage(const SfmStageOptions& options,
                                              uint64_t seed) {
  return std::make_unique<SfmStage>(options, seed);
}

}  // namespace freegs::stages
