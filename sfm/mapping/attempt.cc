// SPDX-License-Identifier: BSD-3-Clause
// Attempts on disk.

#include "sfm/mapping/attempt.h"

#include <algorithm>
#include <climits>
#include <set>
#include <system_error>

#include <nlohmann/json.hpp>

#include "core/io/files.h"
#include "core/io/json_fields.h"
#include "core/io/json_text.h"
#include "sfm/scene/model_io.h"
#include "sfm/scene/reconstruction_measures.h"

namespace freegs::sfm {
namespace {

namespace fs = std::filesystem;

std::string StepName(const std::string& name) { return "attempt: " + name; }

}  // namespace

void AddOthers(const std::vector<Reconstruction>& others,
               std::vector<Reconstruction>* models) {
  std::set<std::string> placed;
  for (const Reconstruction& model : *models) {
    for (const PosedImage& image : model.images) placed.insert(image.name);
  }
  for (size_t i = 1; i < others.size(); ++i) {
    const std::vector<PosedImage>& images = others[i].images;
    if (std::none_of(images.begin(), images.end(), [&](const auto& image) {
          return placed.contains(image.name);
        })) {
      models->push_back(others[i]);
    }
  }
}

Attempt DescribeAttempt(const std::string& name,
                        const std::string& why,
                        const std::vector<Reconstruction>& models) {
  Attempt attempt;
  attempt.name = name;
  attempt.why = why;
  attempt.models = static_cast<int>(models.size());
  if (models.empty()) return attempt;
  const ReconstructionMeasures measures = MeasureReconstruction(models[0]);
  attempt.registered = static_cast<int>(models[0].images.size());
  attempt.points = measures.num_points;
  attempt.mean_error_px = measures.mean_reprojection_error_px;
  return attempt;
}

fs::path AttemptStore::Folder(const std::string& name) const {
  std::string file = name;
  for (char& c : file) {
    if (c == ' ') c = '_';
  }
  return folder_ / file;
}

StatusOr<AttemptResult> AttemptStore::Run(
    const std::string& name,
    const std::function<StatusOr<AttemptResult>()>& run) {
  if (record_->Has(StepName(name))) {
    StatusOr<AttemptResult> known = Read(name);
    if (known.ok()) return known;
    // Somebody meddled with the folder: once more.
  }
  std::error_code error;
  fs::remove_all(Folder(name), error);
  FREEGS_RETURN_IF_ERROR(CreateFolders(Folder(name)));
  FREEGS_ASSIGN_OR_RETURN(AttemptResult result, run());
  FREEGS_RETURN_IF_ERROR(Write(name, result));
  FREEGS_RETURN_IF_ERROR(record_->Add(StepName(name)));
  return result;
}

StatusOr<AttemptResult> AttemptStore::Try(
    const std::string& name,
    const std::function<StatusOr<AttemptResult>()>& run) {
  StatusOr<AttemptResult> result = Run(name, run);
  if (result.ok()) return result;
  const StatusCode code = result.status().code();
  if (code == StatusCode::kInterrupted || code == StatusCode::kInternal) {
    return result;
  }
  AttemptResult nothing;
  nothing.problem = result.status().message();
  return nothing;
}

Status AttemptStore::Write(const std::string& name,
                           const AttemptResult& result) {
  const fs::path folder = Folder(name);
  for (size_t i = 0; i < result.models.size(); ++i) {
    FREEGS_RETURN_IF_ERROR(
        WriteModel(folder / "models" / std::to_string(i), result.models[i]));
  }
  const nlohmann::json json = {{"models", result.models.size()}};
  return WriteFileAtomic(folder / "result.json", JsonText(json));
}

StatusOr<AttemptResult> AttemptStore::Read(const std::string& name) const {
  const fs::path path = Folder(name) / "result.json";
  FREEGS_ASSIGN_OR_RETURN(const std::string text, ReadFile(path, 1 << 20));
  FREEGS_ASSIGN_OR_RETURN(const nlohmann::json json,
                          ParseJsonObject(text, path.string()));
  Status status;
  JsonObjectReader reader(json, path.string(), "", &status);
  AttemptResult result;
  const int count = reader.Integer("models", 0, INT_MAX);
  FREEGS_RETURN_IF_ERROR(status);
  for (int i = 0; i < count; ++i) {
    FREEGS_ASSIGN_OR_RETURN(
        Reconstruction model,
        ReadModel(Folder(name) / "models" / std::to_string(i)));
    result.models.push_back(std::move(model));
  }
  return result;
}

void AttemptStore::Remove(const fs::path& work_folder) {
  std::error_code ignored;
  fs::remove_all(work_folder / "attempts", ignored);
}

}  // namespace freegs::sfm
