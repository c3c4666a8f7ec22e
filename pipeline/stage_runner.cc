// SPDX-License-Identifier: BSD-3-Clause

#include "pipeline/stage_runner.h"

#include <algorithm>
#include <exception>
#include <malloc.h>
#include <mutex>
#include <system_error>
#include <utility>

#include "core/number_text.h"
#include "core/out_of_memory.h"
#include "pipeline/progress_file.h"
#include "pipeline/progress_line.h"
#include "pipeline/resource_usage.h"
#include "pipeline/stage_output.h"
#include "pipeline/system_info.h"
#include "pipeline/version.h"
#include "pipeline/workspace.h"

namespace freegs::pipeline {
namespace {

namespace fs = std::filesystem;

std::string NameOf(const RunnerStage& stage) {
  return std::string(stage.stage->name());
}

ResourceUsage Sum(const ResourceUsage& a, const ResourceUsage& b) {
  return {a.wall_seconds + b.wall_seconds,
          a.cpu_seconds + b.cpu_seconds,
          std::max(a.peak_memory_bytes, b.peak_memory_bytes)};
}

std::string UsageText(const ResourceUsage& usage) {
  return FormatSeconds(usage.wall_seconds) + " (" +
         FormatSeconds(usage.cpu_seconds) + " CPU, peak " +
         FormatBytes(static_cast<double>(usage.peak_memory_bytes)) + ")";
}

// "sfm: text", unless the text already begins that way.
std::string Prefixed(const std::string& name, const std::string& text) {
  const std::string prefix = name + ": ";
  return text.starts_with(prefix) ? text : prefix + text;
}

// Our code returns errors; libraries below it may throw, for one when memory
// runs out.
Status RunCatching(Stage& stage, StageContext& context) {
  try {
    return stage.Run(context);
  } catch (const std::exception& e) {
    if (IsOutOfMemory(e)) return OutOfMemoryError();
    return InternalError(std::string("unexpected error: ") + e.what());
  }
}

// The allocator keeps much of what the stage before has freed, which would
// count as memory of this one.
void GiveBackFreedMemory() {
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

// What the stage expects and, on top of that, what the stages before it have
// left in this process: pages of libraries, and what those keep for later.
// Nothing is known when a library throws, for one because of a damaged input,
// which Run will report.
MemoryNeed ExpectedCatching(const Stage& stage, const StageContext& context) {
  try {
    MemoryNeed need = stage.ExpectedMemory(context);
    if (need.bytes > 0) {
      need.bytes +=
          std::max<int64_t>(0, ResidentMemoryBytes() - kProgramMemory);
    }
    return need;
  } catch (const std::exception&) {
    return {};
  }
}

// Says what the stage will need, and warns when there is less.
void TellMemory(const std::string& name,
                const MemoryNeed& need,
                Logger& logger) {
  if (need.bytes <= 0) return;
  const int64_t available = Memory().available_bytes;
  const bool enough = need.bytes <= available;
  std::string text =
      name + ": needs about " + FormatBytes(static_cast<double>(need.bytes)) +
      " of memory, " + (enough ? "" : "but only ") +
      FormatBytes(static_cast<double>(available)) + " are available";
  if (!enough) {
    text += "; the system may end it or become very slow";
    if (!need.advice.empty()) text += ". To need less, " + need.advice;
  }
  logger.Log(enough ? LogLevel::kInfo : LogLevel::kWarning, text);
}

}  // namespace

StageRunner::StageRunner(std::vector<RunnerStage> stages,
                         StageRunnerOptions options,
                         const CancellationToken& cancellation,
                         Logger& logger)
    : stages_(std::move(stages)),
      options_(std::move(options)),
      cancellation_(cancellation),
      logger_(logger),
      cache_(options_.workspace, FingerprintCachePath(options_.workspace)) {}

size_t StageRunner::IndexOf(const std::string& name) const {
  return static_cast<size_t>(std::find_if(stages_.begin(),
                                          stages_.end(),
                                          [&](const RunnerStage& s) {
                                            return s.stage->name() == name;
                                          }) -
                             stages_.begin());
}

std::string StageRunner::StageNames() const {
  std::string names;
  for (const RunnerStage& stage : stages_) {
    names += (names.empty() ? "" : ", ") + NameOf(stage);
  }
  return names;
}

Status StageRunner::CheckOptions() const {
  for (const std::string& name :
       {options_.from, options_.to, options_.forced}) {
    if (!name.empty() && IndexOf(name) == stages_.size()) {
      return InvalidArgumentError("there is no stage '" + name +
                                  "'; there are " + StageNames());
    }
  }
  if (!options_.from.empty() && !options_.to.empty() &&
      IndexOf(options_.from) > IndexOf(options_.to)) {
    return InvalidArgumentError("stage " + options_.from + " comes after " +
                                options_.to + "; the order is " + StageNames());
  }
  return Status();
}

StageContext StageRunner::MakeContext(const RunnerStage& stage) const {
  StageContext context;
  context.workspace = options_.workspace;
  context.output = PartialFolder(options_.workspace, stage.stage->name());
  context.images = options_.images;
  context.cancellation = &cancellation_;
  context.checkpoint_interval_seconds = options_.checkpoint_interval_seconds;
  return context;
}

std::vector<fs::path> StageRunner::ReadLater(const std::string& stage) const {
  std::vector<fs::path> parts;
  for (size_t i = IndexOf(stage) + 1; i < stages_.size(); ++i) {
    const StageContext context = MakeContext(stages_[i]);
    for (const fs::path& input : stages_[i].stage->Inputs(context)) {
      const fs::path path =
          DisplayPath(options_.workspace, options_.workspace / input);
      if (!input.empty() && *path.begin() == stage) {
        parts.push_back(path.lexically_relative(stage));
      }
    }
  }
  return parts;
}

Status StageRunner::Recover() {
  for (const RunnerStage& stage : stages_) {
    FREEGS_RETURN_IF_ERROR(RecoverStage(options_.workspace, NameOf(stage)));
  }
  return Status();
}

StatusOr<std::vector<StageReport>> StageRunner::Inspect() {
  std::vector<StageReport> reports;
  std::string unfinished;
  for (const RunnerStage& stage : stages_) {
    const CurrentInputs now = GatherInputs(stage, MakeContext(stage), cache_);
    StageReport report{
        NameOf(stage),
        InspectStage(
            options_.workspace, NameOf(stage), now, ReadLater(NameOf(stage)))};
    if (report.state.status == StageStatus::kDone && !unfinished.empty()) {
      report.state.status = StageStatus::kStale;
      report.state.reason = "stage " + unfinished + " is not done";
    }
    if (report.state.status != StageStatus::kDone &&
        report.state.status != StageStatus::kForeign && unfinished.empty()) {
      unfinished = report.stage;
    }
    reports.push_back(std::move(report));
  }
  // Without its cache the next look only takes longer.
  (void)cache_.Save();
  return reports;
}

Status StageRunner::Run() {
  FREEGS_RETURN_IF_ERROR(CheckOptions());
  FREEGS_RETURN_IF_ERROR(Recover());
  const size_t first = options_.from.empty() ? 0 : IndexOf(options_.from);
  const size_t last =
      options_.to.empty() ? stages_.size() : IndexOf(options_.to) + 1;
  for (size_t i = 0; i < first; ++i) {
    std::error_code error;
    const std::string name = NameOf(stages_[i]);
    if (!fs::is_directory(StageFolder(options_.workspace, name), error)) {
      return BadInputError("stage " + name + " has no result in " +
                           options_.workspace.string() +
                           " to start from; run it first");
    }
  }
  ThreadPool pool(WorkingThreads(options_.num_threads));
  std::string redone;
  for (size_t i = first; i < last; ++i) {
    RunnerStage& stage = stages_[i];
    const std::string name = NameOf(stage);
    if (cancellation_.cancelled()) {
      return InterruptedError("interrupted before stage " + name +
                              "; the same command goes on from there");
    }
    const CurrentInputs now = GatherInputs(stage, MakeContext(stage), cache_);
    StageState state =
        InspectStage(options_.workspace, name, now, ReadLater(name));
    if (!state.note.empty()) {
      logger_.Log(LogLevel::kWarning, name + ": " + state.note);
    }
    if (state.status == StageStatus::kForeign) {
      return BadInputError(name + ": " + state.reason);
    }
    if (state.status == StageStatus::kDone) {
      if (name == options_.forced) {
        state.reason = "redone as asked";
      } else if (!redone.empty()) {
        state.reason = "stage " + redone + " was redone";
      } else {
        logger_.Log(LogLevel::kInfo, name + ": up to date");
        continue;
      }
    }
    if (state.status == StageStatus::kFailed) {
      state.reason = state.resumable ? "trying again where it failed"
                                     : "trying again after a failure";
    }
    logger_.Log(LogLevel::kInfo, name + ": " + state.reason);
    FREEGS_RETURN_IF_ERROR(
        RunStage(stage, now.fingerprint, state.resumable, pool));
    // Files that are made again are the same as before, or the fingerprints of
    // what follows tell.
    if (redone.empty() && !state.lacks_files) redone = name;
    (void)cache_.Save();
  }
  (void)cache_.Save();
  return Status();
}

Status StageRunner::RunStage(RunnerStage& stage,
                             const StageFingerprint& fingerprint,
                             bool resume,
                             ThreadPool& pool) {
  const std::string name = NameOf(stage);
  StageContext context = MakeContext(stage);
  ResourceUsage earlier;
  if (resume) {
    FREEGS_RETURN_IF_ERROR(ContinuePartial(context.output));
    earlier = ReadPartialUsage(context.output);
  } else {
    FREEGS_RETURN_IF_ERROR(BeginPartial(context.output, fingerprint));
  }

  context.pool = &pool;
  GiveBackFreedMemory();
  const MemoryNeed need = ExpectedCatching(*stage.stage, context);
  TellMemory(name, need, logger_);
  const ResourceMeter meter;
  ProgressLine line(&logger_, name);
  ProgressFile file(options_.workspace, name);
  context.preview = PreviewPath(options_.workspace);
  std::mutex usage_mutex;
  double usage_noted = 0;
  context.resuming = resume;
  context.earlier_seconds = earlier.wall_seconds;
  context.log = [this, name](LogLevel level, const std::string& text) {
    logger_.Log(level, Prefixed(name, text));
  };
  context.progress = [&](const Progress& progress) {
    line.Report(progress);
    file.Report(progress);
    const std::lock_guard lock(usage_mutex);
    const ResourceUsage usage = meter.Elapsed();
    if (usage.wall_seconds - usage_noted < options_.usage_interval_seconds) {
      return;
    }
    usage_noted = usage.wall_seconds;
    (void)WritePartialUsage(context.output, Sum(earlier, usage));
  };
  const Status status = RunCatching(*stage.stage, context);
  const ResourceUsage usage = Sum(earlier, meter.Elapsed());

  StageRecord record;
  record.fingerprint = fingerprint;
  record.program_version = kProgramVersion;
  record.other_options = stage.other_options;
  record.wall_seconds = usage.wall_seconds;
  record.cpu_seconds = usage.cpu_seconds;
  record.peak_memory_bytes = usage.peak_memory_bytes;
  record.expected_memory_bytes = need.bytes;
  record.resumed = resume;
  if (context.summary.is_object()) record.summary = context.summary;
  if (status.ok()) {
    record.outputs = ListOutputFiles(context.output, ReadLater(name));
    record.contents = StageContents(context.output);
    for (const std::string& name : stage.stage->Disposable()) {
      std::erase(record.contents, name);
    }
    logger_.SetTransient("");
    FREEGS_RETURN_IF_ERROR(FinishPartial(options_.workspace, name, record));
    logger_.Log(LogLevel::kInfo, name + ": done in " + UsageText(usage));
    return Status();
  }

  // A child process that got the same Ctrl-C makes a stage fail in its own
  // words; it was an interruption all the same.
  const bool interrupted =
      status.code() == StatusCode::kInterrupted || cancellation_.cancelled();
  record.outcome =
      interrupted ? StageOutcome::kInterrupted : StageOutcome::kFailed;
  record.error_code = interrupted ? StatusCode::kInterrupted : status.code();
  record.error = status.message();
  // The stage's error matters more than one of writing it down.
  (void)WritePartialUsage(context.output, usage);
  (void)WriteStageRecord(context.output, record);
  logger_.LogToFile(LogLevel::kError, Prefixed(name, status.message()));
  if (interrupted) {
    const bool saved = status.code() == StatusCode::kInterrupted;
    return InterruptedError(
        "interrupted in stage " + name +
        (saved ? "; what it has is saved, the same command goes on from there"
               : "; the same command goes on from what it saved before (" +
                     status.message() + ")"));
  }
  std::string message = Prefixed(name, status.message());
  if (resume && IsWorthContinuing(record)) {
    message +=
        "\nwhat the stage saved earlier is kept, the same command goes "
        "on from there; to begin the stage anew, delete " +
        context.output.string();
  }
  return Status(status.code(), message);
}

}  // namespace freegs::pipeline
