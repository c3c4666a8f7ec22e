// SPDX-License-Identifier: BSD-3-Clause

#include "stages/export/report_data.h"

#include <cmath>
#include <cstdint>
#include <optional>
#include <system_error>

#include <nlohmann/json.hpp>

#include "core/io/files.h"
#include "core/io/json_fields.h"
#include "core/io/json_text.h"
#include "core/number_text.h"
#include "photos/photo_list.h"
#include "pipeline/output_files.h"
#include "pipeline/stage_record.h"
#include "pipeline/version.h"
#include "stages/export/html.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr char kSceneFile[] = "point_cloud.ply";

// Larger files are not a table of a few hundred rows.
constexpr uint64_t kMaxCsvBytes = 64 << 20;

// An empty object when the file is missing or malformed.
json ReadObject(const fs::path& path) {
  const StatusOr<json> document = ReadJson(path);
  return document.ok() && document->is_object() ? *document : json::object();
}

std::optional<double> Number(const json& object, const char* key) {
  const StatusOr<double> number = ReadNumber(FindField(object, key), key);
  return number.ok() ? std::optional(*number) : std::nullopt;
}

std::string Text(const json& object, const char* key) {
  const StatusOr<std::string> text = ReadText(FindField(object, key), key);
  return text.ok() ? *text : "";
}

std::string Count(std::optional<double> number) {
  if (!number || !(std::abs(*number) < 1e15)) return "";
  return FormatCount(static_cast<int64_t>(*number));
}

std::string Fixed(std::optional<double> number,
                  int decimals,
                  const std::string& unit = "") {
  return number ? FormatFixed(*number, decimals) + unit : "";
}

ReportFigure PhotosFigure(const fs::path& workspace) {
  ReportFigure figure{"Photos", "", ""};
  const StatusOr<photos::PhotoList> photos =
      photos::ReadPhotoList(workspace / "ingest" / "images.json");
  if (!photos.ok()) return figure;
  const int holdout = photos->Count(photos::PhotoSplit::kHoldout);
  const int rejected = photos->Count(photos::PhotoSplit::kRejected);
  figure.value = FormatCount(std::ssize(photos->photos) - rejected);
  figure.note = std::to_string(holdout) + " kept from training";
  if (rejected > 0)
    figure.note += ", " + std::to_string(rejected) + " not used";
  return figure;
}

void AddSfmFigures(const json& health, ReportData* data) {
  const std::optional<double> images = Number(health, "images");
  const std::optional<double> registered = Number(health, "registered");
  ReportFigure figure{"Registered", "", ""};
  if (images && registered) {
    figure.value = Count(registered) + " of " + Count(images);
    if (*images > 0) {
      figure.note = FormatPercent(*registered / *images);
    }
  }
  data->figures.push_back(figure);
  data->figures.push_back(
      {"Reprojection error",
       Fixed(Number(health, "mean_reprojection_error_px"), 2, " px"),
       "mean"});
  const std::string verdict = Text(health, "verdict");
  if (verdict == "degraded" || verdict == "failed") {
    const std::string advice = Text(health, "advice");
    data->warnings.push_back("Structure from motion: " + verdict + ". " +
                             Text(health, "reason") +
                             (advice.empty() ? "" : "; " + advice));
  }
}

void AddReplacedModelFigures(size_t num_gaussians, ReportData* data) {
  data->figures.push_back(
      {"Holdout PSNR", "", "not measured for a scene put in by hand"});
  data->figures.push_back({"Gaussians",
                           FormatCount(static_cast<int64_t>(num_gaussians)),
                           "put in by hand"});
  data->warnings.push_back(
      "The scene (reconstruct/point_cloud.ply) is not the one that stage "
      "reconstruct wrote. What was measured of that one, such as its PSNR and "
      "the course of its training, is left out.");
}

void AddModelFigures(const json& metrics, ReportData* data) {
  const std::optional<double> ssim = Number(metrics, "holdout_ssim");
  data->figures.push_back({"Holdout PSNR",
                           Fixed(Number(metrics, "holdout_psnr"), 2, " dB"),
                           ssim ? "SSIM " + Fixed(ssim, 3) : ""});
  const std::optional<double> iterations = Number(metrics, "iterations");
  std::string note;
  if (iterations) {
    note = *iterations > 0 ? Count(iterations) + " iterations" : "imported";
  }
  data->figures.push_back(
      {"Gaussians", Count(Number(metrics, "num_gaussians")), note});
}

}  // namespace

bool IsSceneReplaced(const fs::path& workspace) {
  const StatusOr<pipeline::StageRecord> record =
      pipeline::ReadStageRecord(workspace / "reconstruct");
  if (!record.ok()) return false;
  const pipeline::OutputFiles now =
      pipeline::ListOutputFiles(workspace / "reconstruct", {kSceneFile});
  const auto then = record->outputs.find(kSceneFile);
  const auto found = now.find(kSceneFile);
  return then != record->outputs.end() && found != now.end() &&
         then->second != found->second;
}

ReportData GatherReportData(const fs::path& workspace, size_t num_gaussians) {
  const bool replaced = IsSceneReplaced(workspace);
  ReportData data;
  std::error_code error;
  const std::string name =
      fs::weakly_canonical(workspace, error).filename().string();
  data.title = name.empty() ? "Scene" : name;

  data.figures.push_back(PhotosFigure(workspace));
  if (!data.figures.back().value.empty()) {
    data.subtitle =
        "3D scene from " + data.figures.back().value + " photographs";
  }
  AddSfmFigures(ReadObject(workspace / "sfm" / "health.json"), &data);
  if (replaced) {
    AddReplacedModelFigures(num_gaussians, &data);
  } else {
    AddModelFigures(ReadObject(workspace / "reconstruct" / "metrics.json"),
                    &data);
  }

  double seconds = 0;
  for (const char* stage :
       {"ingest", "sfm", "undistort", "reconstruct", "bootstrap"}) {
    ReportStage row{stage, std::nullopt, std::nullopt, std::nullopt};
    const StatusOr<pipeline::StageRecord> record =
        pipeline::ReadStageRecord(workspace / stage);
    if (record.ok()) {
      row.wall_seconds = record->wall_seconds;
      row.cpu_seconds = record->cpu_seconds;
      row.peak_memory_bytes = record->peak_memory_bytes;
      seconds += record->wall_seconds;
    }
    data.stages.push_back(row);
  }
  data.figures.push_back({kInstancesFigure, "", ""});
  const json bootstrap = ReadObject(workspace / "bootstrap" / "metrics.json");
  const StatusOr<int> withheld =
      ReadInteger(FindField(bootstrap, "num_words_withheld"), 0, 1 << 30, "");
  data.num_words_withheld = withheld.ok() ? *withheld : 0;
  data.figures.push_back(
      {"Time", seconds > 0 ? FormatSeconds(seconds) : "", "without export"});

  const StatusOr<std::string> progress =
      ReadFile(workspace / "reconstruct" / "progress.csv", kMaxCsvBytes);
  if (progress.ok() && !replaced) data.curves = ParseTrainingCurves(*progress);
  data.footer =
      std::string("Made by freegs_pipeline ") + pipeline::kProgramVersion;
  return data;
}

std::map<std::string, ViewFigures> ReadHoldoutFigures(
    const fs::path& workspace) {
  std::map<std::string, ViewFigures> figures;
  if (IsSceneReplaced(workspace)) return figures;
  const json metrics = ReadObject(workspace / "reconstruct" / "metrics.json");
  const json* views = FindField(metrics, "holdout_views");
  if (views == nullptr || !views->is_array()) return figures;
  for (const json& view : *views) {
    if (!view.is_object()) continue;
    figures[Text(view, "name")] = {Number(view, "psnr"), Number(view, "ssim")};
  }
  return figures;
}

}  // namespace freegs::stages
