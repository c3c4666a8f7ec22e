// SPDX-License-Identifier: BSD-3-Clause
// A stage, as the runner sees it: a name, the files it reads, and a function
// that fills a folder. The runner does everything else: it compares
// fingerprints, skips stages whose results hold, makes the temporary folder,
// writes stage.json, shows progress and handles interruption.

#ifndef FREEGS_PIPELINE_STAGE_H_
#define FREEGS_PIPELINE_STAGE_H_

#include <chrono>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/cancellation.h"
#include "core/parallel.h"
#include "core/status.h"
#include "pipeline/forecast/scene_outlook.h"
#include "pipeline/forecast/stage_need.h"

namespace freegs::pipeline {

// The severity of a line of the log, which goes to stderr and to
// WORKSPACE/log.txt.
enum class LogLevel { kInfo, kWarning, kError };
using LogFn = std::function<void(LogLevel, const std::string&)>;

// Everything a running stage is given.
struct StageContext {
  // The workspace; earlier stages' finished output lies in workspace / NAME.
  std::filesystem::path workspace;

  // Where this stage writes: a temporary folder, which the runner renames to
  // workspace / name() when Run succeeds. When a run is killed the folder
  // stays. The next run with the same inputs and options gets it back
  // unchanged, so that it finds the checkpoints that were written here.
  std::filesystem::path output;

  // Whether `output` holds what an interrupted run with the same inputs and
  // options left behind.
  bool resuming = false;

  // The folder of photos on the command line. Only ingest reads it.
  std::filesystem::path images;

  // The runner sets these before it calls Run, so there none is null or empty.
  // Foretell may use the pool, and Inputs none of them. `log` writes the name
  // of the stage before each line.
  ThreadPool* pool = nullptr;
  const CancellationToken* cancellation = nullptr;
  ProgressFn progress;
  LogFn log;

  // A JPEG file that a long stage may write now and then, for those who look on
  // (docs/view.md): a picture of what it has so far. It is no part of the
  // output; the runner deletes it. Empty: nobody wants one.
  std::filesystem::path preview;

  // Seconds between checkpoints of long stages.
  double checkpoint_interval_seconds = 60;

  // Wall and CPU seconds that earlier, interrupted runs into this `output`
  // took.
  double earlier_seconds = 0;
  double earlier_cpu_seconds = 0;

  // When Run is wanted to end. A stage that can end sooner with a lesser result
  // does, and says so; the others take no notice.
  std::optional<std::chrono::steady_clock::time_point> deadline;

  // Free-form facts a stage wants to see in stage.json (counts, warnings).
  nlohmann::json summary = nlohmann::json::object();
};

// A stage of the pipeline:
//
//   class CountStage : public Stage {
//    public:
//     std::string_view name() const override { return "count"; }
//     std::vector<std::filesystem::path> Inputs(
//         const StageContext& context) const override {
//       return {context.workspace / "ingest" / "images.json"};
//     }
//     Status Run(StageContext& context) override {
//       return WriteFileAtomic(context.output / "count.txt", "7\n");
//     }
//   };
class Stage {
 public:
  virtual ~Stage() = default;

  // The name of the folder in the workspace and of the section of options.
  virtual std::string_view name() const = 0;

  // To be raised when the stage writes something else than before for the same
  // inputs, so that results of older programs are made anew.
  virtual int version() const { return 1; }

  // The files and folders whose content decides the result. Paths are relative
  // to the workspace, or absolute (photos, an imported model). A folder counts
  // with all files below it.
  virtual std::vector<std::filesystem::path> Inputs(
      const StageContext& context) const = 0;

  // Foretells what Run is going to need, from the options, the context
  // (workspace, images and pool) and `scene`, which the stages before have
  // filled in. Then writes into `scene` what this stage makes of it: what its
  // files say when it is done, and otherwise what it expects. It takes no more
  // than a moment and reports no errors: of inputs that cannot be used nothing
  // is known.
  virtual StageNeed Foretell(const StageContext&,
                             bool /*done*/,
                             SceneOutlook* /*scene*/) const {
    return {};
  }

  // The names, directly in the stage's folder, of files and folders that nobody
  // needs once the stage is done. A run warns when any other name has been
  // deleted.
  virtual std::vector<std::string> Disposable() const { return {}; }

  // Fills context.output. When cancelled, saves a checkpoint and returns
  // kInterrupted. The messages of errors do not name the stage, because the
  // runner does.
  virtual Status Run(StageContext& context) = 0;
};

}  // namespace freegs::pipeline

#endif  // FREEGS_PIPELINE_STAGE_H_
