// SPDX-License-Identifier: BSD-3-Clause

#include "stages/bench/cell_runner.h"

#include <algorithm>
#include <atomic>
#include <mutex>
#include <system_error>
#include <thread>
#include <utility>

#include <nlohmann/json.hpp>

#include "core/io/files.h"
#include "core/io/json_text.h"
#include "core/number_text.h"
#include "pipeline/exit_code.h"
#include "pipeline/workspace.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;

constexpr size_t kCellHashDigits = 8;

// A folder name that says a little, and is only this cell's.
std::string FolderName(const Suite& suite, const SuiteCell& cell) {
  std::string name = suite.scenes[cell.scene].name + "_" + cell.grid + "_" +
                     std::to_string(cell.seed) + "_" +
                     HashBytes(cell.id).substr(0, kCellHashDigits);
  std::replace(name.begin(), name.end(), ' ', '_');
  return name;
}

// Makes OUT/cells/NAME a workspace of links to the stored stages, which the
// other commands can read.
Status MakeWorkspace(const CellPlan& plan, const fs::path& folder) {
  std::error_code error;
  fs::remove_all(folder, error);
  FREEGS_RETURN_IF_ERROR(CreateFolders(folder));
  for (const StoredStage& stage : plan.stages) {
    if (!fs::exists(stage.workspace / stage.stage, error)) continue;
    FREEGS_RETURN_IF_ERROR(LinkStage(stage, folder));
  }
  pipeline::WorkspaceInfo info;
  info.images = plan.images;
  for (const auto& [name, value] : plan.settings) info.settings[name] = value;
  return pipeline::WriteWorkspaceInfo(folder, info);
}

void Take(const ChildOutcome& outcome,
          const std::string& stage,
          CellResult* result) {
  for (const std::string& line : outcome.said) {
    result->said.push_back({stage, line});
  }
  for (const std::string& line : outcome.kinds) {
    result->kinds.push_back({stage, line});
  }
  result->programs.insert(outcome.programs.begin(), outcome.programs.end());
  if (outcome.ok()) return;
  result->status = CellStatus::kFailed;
  result->exit_code = outcome.exit_code;
  result->failed_stage = stage;
  result->reason = outcome.reason;
}

class Runner {
 public:
  Runner(const Suite& suite,
         const std::vector<SuiteCell>& cells,
         const std::vector<ScenePhotos>& photos,
         const BenchContext& context,
         const CellRunnerOptions& options)
      : suite_(suite),
        cells_(cells),
        photos_(photos),
        context_(context),
        options_(options),
        store_(context, suite.to),
        results_(cells.size()) {}

  StatusOr<std::vector<CellResult>> Run() {
    const size_t jobs = std::min(
        static_cast<size_t>(std::max(1, options_.jobs)), cells_.size());
    std::vector<std::thread> threads;
    for (size_t i = 0; i < jobs; ++i) {
      threads.emplace_back([this] { Work(); });
    }
    for (std::thread& thread : threads) thread.join();
    if (!error_.ok()) return error_;
    return std::move(results_);
  }

 private:
  void Work() {
    while (!failed_) {
      const size_t i = next_++;
      if (i >= cells_.size()) return;
      StatusOr<CellResult> result = RunCell(i);
      const std::lock_guard lock(mutex_);
      Status status = result.status();
      if (status.ok()) {
        results_[i] = *std::move(result);
        status = options_.finished(results_);
      }
      if (status.ok()) continue;
      if (error_.ok()) error_ = std::move(status);
      failed_ = true;
    }
  }

  StatusOr<CellResult> RunCell(size_t i) {
    const SuiteCell& cell = cells_[i];
    const std::string title = std::to_string(i + 1) + "/" +
                              std::to_string(cells_.size()) + " " + cell.id;
    const StatusOr<CellPlan> planned = store_.Plan(cell, photos_[cell.scene]);
    if (!planned.ok()) return Unplanned(title, planned.status());
    const CellPlan& plan = *planned;
    CellResult result;
    for (size_t k = 0; k < plan.stages.size(); ++k) {
      const StoredStage& stage = plan.stages[k];
      if (!store_.IsDone(stage)) context_.say(title + ": " + stage.stage);
      FREEGS_ASSIGN_OR_RETURN(const ChildOutcome outcome,
                              store_.RunStage(plan, k));
      Take(outcome, stage.stage, &result);
      AddStageFigures(stage.workspace, stage.stage, &result);
      result.log =
          (fs::path("store") / stage.workspace.filename() / "log.txt").string();
      if (!outcome.ok()) break;
    }
    if (result.status != CellStatus::kFailed && !plan.evaluation.empty()) {
      FREEGS_ASSIGN_OR_RETURN(const ChildOutcome outcome,
                              store_.Evaluate(plan));
      Take(outcome, "eval", &result);
      if (outcome.ok()) {
        FREEGS_RETURN_IF_ERROR(
            AddEvaluation(plan.evaluation / "eval.json", &result));
      }
    }
    if (result.status != CellStatus::kFailed) result.status = CellStatus::kDone;
    const fs::path folder = fs::path("cells") / FolderName(suite_, cell);
    result.folder = folder.string();
    FREEGS_RETURN_IF_ERROR(MakeWorkspace(plan, context_.out / folder));
    FREEGS_RETURN_IF_ERROR(
        WriteFileAtomic(context_.out / folder / "cell.json",
                        JsonText(ToJson(suite_, cell, result))));
    Tell(title, result);
    return result;
  }

  // The result of a cell whose photographs cannot be disturbed, or whose
  // options do not go together.
  StatusOr<CellResult> Unplanned(const std::string& title,
                                 const Status& status) const {
    if (status.code() == StatusCode::kInterrupted ||
        status.code() == StatusCode::kInternal) {
      return status;
    }
    CellResult result;
    result.status = CellStatus::kFailed;
    result.exit_code = pipeline::ExitCode(status.code());
    result.failed_stage = "preparation";
    result.reason = status.message();
    Tell(title, result);
    return result;
  }

  void Tell(const std::string& title, const CellResult& result) const {
    if (result.status == CellStatus::kFailed) {
      context_.say(title + ": failed in " + result.failed_stage +
                   " with exit code " + std::to_string(result.exit_code) +
                   ": " + result.reason);
      return;
    }
    std::string text = title + ": done";
    const auto add = [&](const char* name, const char* what, int digits) {
      const auto value = result.values.find(name);
      if (value == result.values.end()) return;
      text +=
          std::string(", ") + what + " " + FormatFixed(value->second, digits);
    };
    add("total.cpu_seconds", "CPU seconds", 1);
    add("holdout_psnr", "holdout PSNR", 2);
    add("instance_miou", "instance mIoU", 3);
    context_.say(text);
  }

  const Suite& suite_;
  const std::vector<SuiteCell>& cells_;
  const std::vector<ScenePhotos>& photos_;
  const BenchContext& context_;
  const CellRunnerOptions& options_;
  StageStore store_;
  std::atomic<size_t> next_{0};
  std::atomic<bool> failed_{false};
  std::mutex mutex_;  // Guards what follows.
  std::vector<CellResult> results_;
  Status error_;
};

}  // namespace

StatusOr<std::vector<ScenePhotos>> FindAllPhotos(const Suite& suite,
                                                 const BenchContext& context) {
  std::vector<ScenePhotos> photos;
  for (const SuiteScene& scene : suite.scenes) {
    FREEGS_ASSIGN_OR_RETURN(ScenePhotos of_scene,
                            FindScenePhotos(scene, context));
    photos.push_back(std::move(of_scene));
  }
  return photos;
}

StatusOr<std::vector<CellResult>> RunCells(
    const Suite& suite,
    const std::vector<SuiteCell>& cells,
    const std::vector<ScenePhotos>& photos,
    const BenchContext& context,
    const CellRunnerOptions& options) {
  return Runner(suite, cells, photos, context, options).Run();
}

}  // namespace freegs::stages
