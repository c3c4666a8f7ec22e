// SPDX-License-Identifier: BSD-3-Clause
// The order of the steps, and which of them are done.

#include "sfm/structure_from_motion.h"

#include <algorithm>
#include <set>
#include <system_error>
#include <thread>

#include <nlohmann/json.hpp>

#include "core/files.h"
#include "sfm/colmap_program.h"
#include "sfm/colmap_steps.h"
#include "sfm/match_database.h"

namespace freegs::sfm {
namespace {

namespace fs = std::filesystem;

// What is finished, in work_folder/steps.json. A step is recorded after its
// files are complete; a step that is not recorded is done again.
class StepRecord {
 public:
  explicit StepRecord(const fs::path& folder) : path_(folder / "steps.json") {
    const StatusOr<std::string> text = ReadFile(path_, 1 << 20);
    if (!text.ok()) return;
    const auto json = nlohmann::json::parse(*text, nullptr, false);
    if (!json.is_object()) return;
    for (const auto& [key, values] : json.items()) {
      if (!values.is_array()) continue;
      for (const auto& value : values) {
        if (key == "done" && value.is_string()) done_.insert(value);
        if (key == "matched_portions" && value.is_number_integer()) {
          portions_.insert(value.get<int>());
        }
      }
    }
  }

  bool Has(const std::string& step) const { return done_.contains(step); }
  const std::set<int>& portions() const { return portions_; }

  Status Add(const std::string& step) {
    done_.insert(step);
    return Save();
  }
  Status AddPortion(int portion) {
    portions_.insert(portion);
    return Save();
  }

 private:
  Status Save() const {
    const nlohmann::json json = {{"done", done_},
                                 {"matched_portions", portions_}};
    return WriteFileAtomic(path_, json.dump(2) + "\n");
  }

  fs::path path_;
  std::set<std::string> done_;
  std::set<int> portions_;
};

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

size_t NumRegistered(const std::vector<Reconstruction>& models) {
  return models.empty() ? 0 : models[0].images.size();
}

// Why photos are not in the best model.
Status ExplainUnregistered(const SfmInput& input,
                           const fs::path& database_path,
                           SfmResult* result) {
  FREEGS_ASSIGN_OR_RETURN(const MatchDatabase database,
                          MatchDatabase::Open(database_path));
  FREEGS_ASSIGN_OR_RETURN(const auto photos, database.Photos());
  FREEGS_ASSIGN_OR_RETURN(const auto verified, database.VerifiedMatches());
  std::set<std::string> registered;
  if (!result->models.empty()) {
    for (const PosedImage& image : result->models[0].images) {
      registered.insert(image.name);
    }
  }
  for (const SfmPhoto& photo : input.photos) {
    if (registered.contains(photo.name)) continue;
    std::string& reason = result->unregistered[photo.name];
    const auto row =
        std::find_if(photos.begin(), photos.end(), [&](const auto& candidate) {
          return candidate.name == photo.name;
        });
    if (row == photos.end()) {
      reason = "COLMAP could not read it";
      continue;
    }
    const auto match = std::find_if(
        verified.begin(), verified.end(), [&](const auto& candidate) {
          return candidate.photo_id == row->id;
        });
    reason = std::to_string(row->num_features) + " features; ";
    if (match == verified.end()) {
      reason += "matches no other photo";
      continue;
    }
    reason += "matches " + std::to_string(match->num_photos) + " photos with " +
              std::to_string(match->num_matches) + " features in all";
    for (size_t k = 1; k < result->models.size(); ++k) {
      const auto& images = result->models[k].images;
      if (std::any_of(images.begin(), images.end(), [&](const auto& image) {
            return image.name == photo.name;
          })) {
        reason += "; part of the separate model sparse/" + std::to_string(k);
        break;
      }
    }
  }
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
  const fs::path folder = input.work_folder / "mapper";
  FREEGS_ASSIGN_OR_RETURN(
      result.models, MapPhotos(context, database, folder, /*relaxed=*/false));
  SortBySize(&result.models);
  if (NumRegistered(result.models) * 10 < input.photos.size() * 9) {
    FREEGS_ASSIGN_OR_RETURN(
        std::vector<Reconstruction> relaxed,
        MapPhotos(context, database, folder, /*relaxed=*/true));
    SortBySize(&relaxed);
    if (NumRegistered(relaxed) > NumRegistered(result.models)) {
      result.warnings.push_back(
          "mapped with lower thresholds, as the usual ones registered only " +
          std::to_string(NumRegistered(result.models)) + " of " +
          std::to_string(input.photos.size()) + " photos");
      result.models = std::move(relaxed);
    }
  }
  std::error_code ignored;
  fs::remove_all(folder, ignored);
  fs::remove(input.work_folder / "image_list.txt", ignored);
  FREEGS_RETURN_IF_ERROR(ExplainUnregistered(input, database, &result));
  return result;
}

}  // namespace freegs::sfm
