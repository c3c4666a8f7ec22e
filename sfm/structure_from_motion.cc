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
#include "sfm/view_graph.h"

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
      if (key == "pairs") ReadPairs(values);
      if (key == "image_size" && values.is_number_integer()) {
        image_size_ = values.get<int>();
      }
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
  const MatchedPairs& pairs() const { return pairs_; }
  int image_size() const { return image_size_; }

  Status Add(const std::string& step) {
    done_.insert(step);
    return Save();
  }
  Status AddPortion(int portion) {
    portions_.insert(portion);
    return Save();
  }
  Status SetImageSize(int size) {
    image_size_ = size;
    return Save();
  }
  Status AddMatches(const MatchedPairs& pairs) {
    pairs_ = pairs;
    return Add("matches");
  }

 private:
  void ReadPairs(const nlohmann::json& json) {
    if (!json.is_object()) return;
    const auto strategy = json.find("strategy");
    const auto pairs = json.find("pairs");
    const auto all_pairs = json.find("all_pairs");
    if (strategy == json.end() || !strategy->is_string() ||
        pairs == json.end() || !pairs->is_number_unsigned() ||
        all_pairs == json.end() || !all_pairs->is_number_unsigned()) {
      return;
    }
    pairs_ = {strategy->get<std::string>(),
              pairs->get<size_t>(),
              all_pairs->get<size_t>()};
  }

  Status Save() const {
    const nlohmann::json json = {{"done", done_},
                                 {"matched_portions", portions_},
                                 {"image_size", image_size_},
                                 {"pairs",
                                  {{"strategy", pairs_.strategy},
                                   {"image_size", image_size_},
                                   {"pairs", pairs_.pairs},
                                   {"all_pairs", pairs_.all_pairs}}}};
    return WriteFileAtomic(path_, json.dump(2) + "\n");
  }

  fs::path path_;
  std::set<std::string> done_;
  std::set<int> portions_;
  MatchedPairs pairs_;
  int image_size_ = 0;
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
    FREEGS_ASSIGN_OR_RETURN(
        const MatchedPairs pairs,
        MatchFeatures(context, database, record->portions(), [&](int portion) {
          return record->AddPortion(portion);
        }));
    FREEGS_RETURN_IF_ERROR(record->AddMatches(pairs));
  }
  return {};
}

size_t NumRegistered(const std::vector<Reconstruction>& models) {
  return models.empty() ? 0 : models[0].images.size();
}

fs::path MapperFolder(const StepContext& context) {
  return context.input.work_folder / "mapper";
}

// Maps with COLMAP's thresholds, and with lower ones when they leave out many.
Status MapBest(const StepContext& context,
               const fs::path& database,
               SfmResult* result) {
  const fs::path folder = MapperFolder(context);
  const size_t count = context.input.photos.size();
  FREEGS_ASSIGN_OR_RETURN(
      result->models, MapPhotos(context, database, folder, /*relaxed=*/false));
  SortBySize(&result->models);
  const size_t registered = NumRegistered(result->models);
  if (registered * 10 < count * 9) {
    FREEGS_ASSIGN_OR_RETURN(
        std::vector<Reconstruction> relaxed,
        MapPhotos(context, database, folder, /*relaxed=*/true));
    SortBySize(&relaxed);
    if (NumRegistered(relaxed) > registered) {
      result->warnings.push_back(
          "mapped with lower thresholds, as the usual ones registered only " +
          std::to_string(registered) + " of " + std::to_string(count) +
          " photos");
      result->models = std::move(relaxed);
    }
  }
  std::error_code ignored;
  fs::remove_all(folder, ignored);
  return {};
}

// Maps again without the matches that put photos in places which their
// strongest matches contradict, as long as that helps.
Status Reconcile(const StepContext& context,
                 const fs::path& database_path,
                 SfmResult* result) {
  constexpr int kMaxRounds = 3;
  if (result->models.empty()) return {};
  const fs::path trusted_path = context.input.work_folder / "trusted.db";
  Contradictions found;
  {
    FREEGS_ASSIGN_OR_RETURN(const MatchDatabase database,
                            MatchDatabase::Open(database_path));
    FREEGS_ASSIGN_OR_RETURN(const std::vector<PairAgreement> pairs,
                            MeasureAgreement(result->models[0], database));
    found = FindContradictions(pairs);
    if (found.strongest.empty()) return {};
    RemoveDatabase(trusted_path);
    FREEGS_RETURN_IF_ERROR(database.CopyTo(trusted_path));
  }
  const size_t before = found.strongest.size();
  size_t removed = 0;
  for (int round = 0; round < kMaxRounds && !found.suspects.empty(); ++round) {
    Contradictions next;
    SfmResult again;
    {
      FREEGS_ASSIGN_OR_RETURN(MatchDatabase trusted,
                              MatchDatabase::Open(trusted_path));
      FREEGS_RETURN_IF_ERROR(trusted.RemoveVerifiedPairs(found.suspects));
    }
    removed += found.suspects.size();
    FREEGS_RETURN_IF_ERROR(MapBest(context, trusted_path, &again));
    if (again.models.empty()) break;
    {
      // Against what is still trusted.
      FREEGS_ASSIGN_OR_RETURN(const MatchDatabase trusted,
                              MatchDatabase::Open(trusted_path));
      FREEGS_ASSIGN_OR_RETURN(const std::vector<PairAgreement> pairs,
                              MeasureAgreement(again.models[0], trusted));
      next = FindContradictions(pairs);
    }
    const bool fewer = next.strongest.size() < found.strongest.size();
    const bool as_many =
        NumRegistered(again.models) * 10 >= NumRegistered(result->models) * 9;
    if (!fewer || !as_many) break;
    result->models = std::move(again.models);
    result->warnings.insert(
        result->warnings.end(), again.warnings.begin(), again.warnings.end());
    found = std::move(next);
  }
  RemoveDatabase(trusted_path);
  result->contradictions = found.strongest.size();
  result->warnings.push_back(
      "parts of the scene look alike: a first model contradicted " +
      std::to_string(before) + " of the strongest matches; mapped again " +
      "without " + std::to_string(removed) + " matching pairs, which leaves " +
      std::to_string(found.strongest.size()) + " contradicted");
  return {};
}

// Gives the best model the simplest cameras that explain it, and adjusts it.
// COLMAP's estimate stays where there is too little to choose by.
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
  if (FindCameraModel(std::string_view(ColmapCameraModel())) == nullptr) {
    std::string names = "auto";
    for (const CameraModelInfo& model : CameraModels()) {
      names += ", " + std::string(model.name);
    }
    return InvalidArgumentError("sfm.camera_model must be one of " + names);
  }
  if ((max_image_size != 0 && max_image_size < 64) || max_features < 64) {
    return InvalidArgumentError(
        "sfm.max_image_size (unless 0) and sfm.max_features must be at least "
        "64");
  }
  return pairs.Check();
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
  result.pairs = record.pairs();
  result.image_size = resolved.max_image_size;
  result.warnings = colmap.KnownFaults();
  if (record.Has("one extractor thread")) {
    result.warnings.push_back(
        "this COLMAP has no database_cleaner: features were taken by one "
        "thread, to stay repeatable");
  }
  FREEGS_RETURN_IF_ERROR(MapBest(context, database, &result));
  FREEGS_RETURN_IF_ERROR(Reconcile(context, database, &result));
  FREEGS_RETURN_IF_ERROR(ChooseCameras(context, &result));
  std::error_code ignored;
  fs::remove(input.work_folder / "image_list.txt", ignored);
  FREEGS_RETURN_IF_ERROR(ExplainUnregistered(input, database, &result));
  return result;
}

}  // namespace freegs::sfm
