// SPDX-License-Identifier: BSD-3-Clause

#include "stages/view/view_status.h"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <system_error>
#include <utility>

#include <nlohmann/json.hpp>

#include "core/io/files.h"
#include "core/io/json_text.h"
#include "pipeline/progress_file.h"
#include "pipeline/stage_record.h"
#include "pipeline/workspace.h"
#include "stages/export/training_curve.h"
#include "stages/query/file_stamp.h"
#include "stages/registry/stage_registry.h"
#include "stages/view/live_queries.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using pipeline::StageOutcome;
using pipeline::StageRecord;

constexpr uint64_t kMaxCurveBytes = 64 << 20;

struct StageNow {
  std::string state;
  std::optional<double> wall_seconds;
};

// What the files of a stage say. `running` names the stage at work; it is empty
// when none is, or when the run is between two stages.
StageNow StateOf(const fs::path& workspace,
                 const std::string& stage,
                 const std::string& running) {
  if (stage == running) return {"running", std::nullopt};
  std::error_code error;
  const fs::path folder = pipeline::StageFolder(workspace, stage);
  const fs::path partial = pipeline::PartialFolder(workspace, stage);
  if (fs::is_directory(partial, error)) {
    const StatusOr<StageRecord> attempt = pipeline::ReadStageRecord(partial);
    const bool failed =
        attempt.ok() && attempt->outcome == StageOutcome::kFailed;
    return {failed ? "failed" : "interrupted",
            attempt.ok() ? std::optional(attempt->wall_seconds) : std::nullopt};
  }
  const StatusOr<StageRecord> record = pipeline::ReadStageRecord(folder);
  if (record.ok()) return {"done", record->wall_seconds};
  // Without stage.json it is the result of another program.
  return {fs::is_directory(folder, error) ? "foreign" : "pending",
          std::nullopt};
}

json StagesJson(const fs::path& workspace, const std::string& running) {
  json stages = json::array();
  bool after = false;
  for (const std::string& stage : StageNames()) {
    StageNow now = StateOf(workspace, stage, running);
    // What is older than the stage that is made anew will be made anew, too.
    if (after && now.state == "done") now.state = "stale";
    after = after || stage == running;
    stages.push_back(
        {{"name", stage},
         {"state", now.state},
         {"wall_seconds",
          now.wall_seconds ? json(*now.wall_seconds) : json(nullptr)}});
  }
  return stages;
}

json ProgressJson(const pipeline::RunProgress& progress) {
  return {
      {"step", progress.step},
      {"stage", progress.stage},
      {"done", progress.done},
      {"total", progress.total},
      {"seconds_left",
       progress.seconds_left ? json(*progress.seconds_left) : json(nullptr)}};
}

// The columns of the training under way, else of the finished one, with null
// where a value was not measured.
json CurveJson(const fs::path& workspace, bool training) {
  const fs::path folder =
      training ? pipeline::PartialFolder(workspace, "reconstruct")
               : pipeline::StageFolder(workspace, "reconstruct");
  const StatusOr<std::string> csv =
      ReadFile(folder / "progress.csv", kMaxCurveBytes);
  return TrainingCurvesJson(csv.ok() ? ParseTrainingCurves(*csv)
                                     : TrainingCurves());
}

// Empty when there is no report to look at.
std::string ExportVersion(const fs::path& workspace) {
  const fs::path folder = pipeline::StageFolder(workspace, "export");
  const fs::path report = folder / "report" / "index.html";
  std::error_code error;
  if (!fs::exists(report, error)) return "";
  return FileStamp({pipeline::RecordPath(folder), report});
}

std::string WorkspaceName(const fs::path& workspace) {
  std::error_code error;
  const fs::path path = fs::weakly_canonical(workspace, error);
  return ValidUtf8(path.filename().string());
}

}  // namespace

json ViewStatus(const fs::path& workspace) {
  const bool running = pipeline::IsLocked(workspace);
  const StatusOr<pipeline::RunProgress> progress =
      pipeline::ReadProgressFile(workspace);
  const bool known = running && progress.ok();
  const std::string stage = known ? progress->stage : "";
  const bool training = stage == "reconstruct";
  const fs::path preview = pipeline::PreviewPath(workspace);
  std::error_code error;
  const bool has_preview = training && fs::exists(preview, error);
  return {{"live", true},
          {"workspace", WorkspaceName(workspace)},
          {"running", running},
          {"stages", StagesJson(workspace, stage)},
          {"progress", known ? ProgressJson(*progress) : json(nullptr)},
          {"curve", CurveJson(workspace, training)},
          {"preview",
           has_preview ? json("/api/preview.jpg?v=" + FileStamp({preview}))
                       : json(nullptr)},
          {"export_version", ExportVersion(workspace)},
          {"scene_version", QueryStamp(workspace)},
          {"queries", AnswerableQueries(workspace)}};
}

}  // namespace freegs::stages
