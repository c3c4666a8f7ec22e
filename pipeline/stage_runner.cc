// SPDX-License-Identifier: BSD-3-Clause

#include "pipeline/stage_runner.h"

#include <algorithm>
#include <exception>
#include <malloc.h>
#include <mutex>
#include <system_error>
#include <utility>

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

// "sfm: text".
std::string Prefixed(const std::string& name, const std::string& text) {
  return name + ": " + text;
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

// What is written down of a run, whether it succeeds or fails.
StageRecord MakeRecord(const RunnerStage& stage,
                       const StageFingerprint& fingerprint,
                       const StageNeed& need,
                       const ResourceUsage& usage,
                       const StageContext& context) {
  StageRecord record;
  record.fingerprint = fingerprint;
  record.program_version = kProgramVersion;
  record.other_options = stage.other_options;
  record.wall_seconds = usage.wall_seconds;
  record.cpu_seconds = usage.cpu_seconds;
  record.peak_memory_bytes = usage.peak_memory_bytes;
  record.expected_memory_bytes = need.memory_bytes;
  record.expected_seconds = need.seconds;
  record.resumed = context.resuming;
  if (context.summary.is_object()) record.summary = context.summary;
  return record;
}

// What the user is told of a run that did not succeed. `status` is what the
// stage said, `record` what was made of it, and `way_on` the command that goes
// on.
std::string FailureMessage(const std::string& name,
                           const Status& status,
                           const StageRecord& record,
                           const std::string& way_on,
                           const fs::path& output) {
  if (record.outcome == StageOutcome::kInterrupted) {
    const bool saved = status.code() == StatusCode::kInterrupted;
    return "interrupted in stage " + name + "; " + way_on +
           " goes on from what " +
           (saved ? "is saved" : "was saved before (" + status.message() + ")");
  }
  std::string message = Prefixed(name, status.message());
  if (record.resumed && IsWorthContinuing(record)) {
    message += "\nwhat the stage saved earlier is kept, " + way_on +
               " goes on from there; to begin the stage anew, delete " +
               output.string();
  }
  return message;
}

// The allocator keeps much of what the stage before has freed, which would
// count as memory of this one.
void GiveBackFreedMemory() {
#ifdef __GLIBC__
  malloc_trim(0);
#endif
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
      cache_(options_.workspace,
             FingerprintCachePath(options_.workspace),
             &cancellation_) {}

size_t StageRunner::IndexOf(const std::string& name) const {
  return static_cast<size_t>(std::ranges::find(stages_, name, NameOf) -
                             stages_.begin());
}

std::string StageRunner::StageNames() const {
  std::string names;
  for (const RunnerStage& stage : stages_) {
    names += (names.empty() ? "" : ", ") + NameOf(stage);
  }
  return names;
}

size_t StageRunner::First() const {
  return options_.from.empty() ? 0 : IndexOf(options_.from);
}

size_t StageRunner::End() const {
  return options_.to.empty() ? stages_.size() : IndexOf(options_.to) + 1;
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
  return ReadBy(IndexOf(stage) + 1, stages_.size(), stage);
}

std::vector<fs::path> StageRunner::ReadBy(size_t first,
                                          size_t end,
                                          const std::string& stage) const {
  std::vector<fs::path> parts;
  for (size_t i = first; i < end; ++i) {
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
  RemoveProgress(options_.workspace);
  return Status();
}

std::vector<StageReport> StageRunner::States() {
  std::vector<StageReport> reports;
  std::string unfinished;
  for (size_t i = 0; i < stages_.size(); ++i) {
    const RunnerStage& stage = stages_[i];
    const std::string name = NameOf(stage);
    // Nothing is to be compared where nothing is: no photos need to be read.
    std::error_code error;
    CurrentInputs now;
    if (fs::exists(StageFolder(options_.workspace, name), error) ||
        fs::exists(PartialFolder(options_.workspace, name), error)) {
      now = GatherInputs(stage, MakeContext(stage), cache_);
    }
    StageReport report{
        name, InspectStage(options_.workspace, name, now, ReadLater(name))};
    StageState& state = report.state;
    if (state.status == StageStatus::kDone && !unfinished.empty()) {
      state.status = StageStatus::kStale;
      state.reason = "stage " + unfinished + " is not done";
    }
    if (i >= First() && state.status != StageStatus::kDone &&
        state.status != StageStatus::kForeign && unfinished.empty()) {
      unfinished = name;
    }
    reports.push_back(std::move(report));
  }
  return reports;
}

std::vector<StageReport> StageRunner::Inspect() {
  std::vector<StageReport> reports = States();
  // Without its cache the next look only takes longer.
  (void)cache_.Save();
  return reports;
}

StatusOr<std::vector<StageForecast>> StageRunner::Forecast() {
  FREEGS_RETURN_IF_ERROR(CheckOptions());
  ThreadPool pool(WorkingThreads(options_.num_threads));
  std::vector<StageForecast> forecasts = Forecast(pool);
  if (cancellation_.cancelled()) {
    return InterruptedError("interrupted while reading the inputs");
  }
  return forecasts;
}

std::vector<StageForecast> StageRunner::Forecast(ThreadPool& pool) {
  std::vector<StageForecast> forecasts;
  std::vector<bool> done;
  const std::vector<StageReport> reports = States();
  std::string redone;
  for (size_t i = 0; i < reports.size(); ++i) {
    const auto& [name, state] = reports[i];
    const bool in_run = i >= First() && i < End();
    const bool has_result = state.status == StageStatus::kDone;
    const bool forced = name == options_.forced;
    // After a stage whose result is made again although it holds, Run does all
    // stages again.
    const bool follows = in_run && has_result && !redone.empty();
    const bool holds = (has_result && !forced && !follows) ||
                       state.status == StageStatus::kForeign;
    done.push_back(!in_run || holds);
    forecasts.push_back({.stage = name,
                         .needed = !done[i],
                         .reason = forced    ? options_.forced_reason
                                   : follows ? "stage " + redone + " is redone"
                                             : state.reason,
                         .begun = state.resumable});
    if (in_run && has_result && forced) redone = name;
  }
  const std::vector<StageNeed> needs = NeedsOfStages(done, pool);
  for (size_t i = 0; i < needs.size(); ++i) forecasts[i].need = needs[i];
  return forecasts;
}

std::vector<StageNeed> StageRunner::NeedsOfStages(const std::vector<bool>& done,
                                                  ThreadPool& pool) const {
  std::vector<StageNeed> needs;
  SceneOutlook scene;
  bool from_files = true;
  for (size_t i = 0; i < stages_.size(); ++i) {
    StageContext context = MakeContext(stages_[i]);
    context.pool = &pool;
    StageNeed need;
    try {
      need = stages_[i].stage->Foretell(context, done[i], &scene);
    } catch (const std::exception&) {
      // A library does not like an input. Run will report it.
      scene = {};
    }
    need.from_files = from_files;
    from_files = from_files && done[i];
    needs.push_back(std::move(need));
  }
  return needs;
}

Status StageRunner::CheckStart() const {
  for (size_t i = 0; i < First(); ++i) {
    std::error_code error;
    const std::string name = NameOf(stages_[i]);
    if (!ReadBy(First(), End(), name).empty() &&
        !fs::is_directory(StageFolder(options_.workspace, name), error)) {
      return BadInputError("stage " + name + " has no result in " +
                           options_.workspace.string() +
                           " to start from; run it first");
    }
  }
  return Status();
}

StatusOr<bool> StageRunner::NeedsRun(const std::string& name,
                                     const std::string& redone,
                                     StageState* state) {
  if (!state->note.empty()) {
    logger_.Log(LogLevel::kWarning, Prefixed(name, state->note));
  }
  if (state->status == StageStatus::kForeign) {
    return BadInputError(Prefixed(name, state->reason));
  }
  if (state->status == StageStatus::kDone) {
    if (name == options_.forced) {
      state->reason = options_.forced_reason;
    } else if (!redone.empty()) {
      state->reason = "stage " + redone + " was redone";
    } else {
      logger_.Log(LogLevel::kInfo, name + ": up to date");
      // The next run may find them gone, and asks where they lay. Where the
      // record cannot be written, the result holds all the same.
      if (state->inputs_moved) {
        (void)WriteStageRecord(StageFolder(options_.workspace, name),
                               *state->result);
      }
      return false;
    }
  }
  if (!state->waits_for.empty()) {
    return BadInputError(name + ": " + state->waits_for +
                         "; to begin the stage anew, delete " +
                         PartialFolder(options_.workspace, name).string());
  }
  if (state->status == StageStatus::kFailed) {
    state->reason = state->resumable ? "trying again where it failed"
                                     : "trying again after a failure";
  }
  return true;
}

Status StageRunner::Run() {
  FREEGS_RETURN_IF_ERROR(CheckOptions());
  FREEGS_RETURN_IF_ERROR(Recover());
  FREEGS_RETURN_IF_ERROR(CheckStart());
  ThreadPool pool(WorkingThreads(options_.num_threads));
  const std::vector<StageForecast> forecasts = Forecast(pool);
  const std::string expected = RunNeedText(Total(forecasts));
  if (!expected.empty() && !cancellation_.cancelled()) {
    logger_.Log(LogLevel::kInfo, "run: " + expected);
  }
  std::string redone;
  for (size_t i = First(); i < End(); ++i) {
    RunnerStage& stage = stages_[i];
    const std::string name = NameOf(stage);
    const CurrentInputs now = GatherInputs(stage, MakeContext(stage), cache_);
    if (cancellation_.cancelled()) {
      // Not all inputs may have been read. Those that were need not be again.
      (void)cache_.Save();
      return InterruptedError("interrupted before stage " + name + "; " +
                              options_.way_on + " goes on from there");
    }
    StageState state =
        InspectStage(options_.workspace, name, now, ReadLater(name));
    FREEGS_ASSIGN_OR_RETURN(const bool needed, NeedsRun(name, redone, &state));
    if (!needed) continue;
    logger_.Log(LogLevel::kInfo, name + ": " + state.reason);
    std::vector<bool> done(stages_.size());
    std::fill_n(done.begin(), i, true);
    GiveBackFreedMemory();
    const std::vector<StageNeed> needs = NeedsOfStages(done, pool);
    double later_seconds = 0;
    for (size_t j = i + 1; j < End(); ++j) {
      if (forecasts[j].needed) later_seconds += needs[j].seconds;
    }
    FREEGS_RETURN_IF_ERROR(RunStage(stage,
                                    {.need = needs[i],
                                     .later_seconds = later_seconds,
                                     .fingerprint = now.fingerprint,
                                     .resume = state.resumable},
                                    pool));
    // Files that are made again are the same as before, or the fingerprints of
    // what follows tell.
    if (redone.empty() && !state.lacks_files) redone = name;
    (void)cache_.Save();
  }
  (void)cache_.Save();
  return Status();
}

Status StageRunner::RunStage(RunnerStage& stage,
                             StageStart start,
                             ThreadPool& pool) {
  const std::string name = NameOf(stage);
  StageNeed& need = start.need;
  StageContext context = MakeContext(stage);
  ResourceUsage earlier;
  if (start.resume) {
    FREEGS_RETURN_IF_ERROR(ContinuePartial(context.output));
    earlier = ReadPartialUsage(context.output);
  } else {
    FREEGS_RETURN_IF_ERROR(BeginPartial(context.output, start.fingerprint));
  }

  context.pool = &pool;
  if (options_.deadline) {
    const std::chrono::duration<double> later(start.later_seconds);
    context.deadline =
        *options_.deadline -
        std::chrono::duration_cast<std::chrono::steady_clock::duration>(later);
  }
  if (need.known()) {
    // What stages before it have left in this process: pages of libraries, and
    // what those keep for later.
    need.memory_bytes +=
        std::max<int64_t>(0, ResidentMemoryBytes() - kProgramMemory);
    // What this process holds already is part of the need.
    const int64_t available = Memory().available_bytes + ResidentMemoryBytes();
    logger_.Log(
        need.memory_bytes > available ? LogLevel::kWarning : LogLevel::kInfo,
        name + ": " + MemoryText(need, available));
  }
  const ResourceMeter meter(PeakMemory::kReset);
  ProgressLine line(&logger_,
                    name,
                    {std::max(0.0, need.seconds - earlier.wall_seconds),
                     start.later_seconds});
  ProgressFile file(options_.workspace, name);
  context.preview = PreviewPath(options_.workspace);
  std::mutex usage_mutex;
  double usage_noted = 0;
  context.resuming = start.resume;
  context.earlier_seconds = earlier.wall_seconds;
  context.earlier_cpu_seconds = earlier.cpu_seconds;
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

  StageRecord record =
      MakeRecord(stage, start.fingerprint, need, usage, context);
  if (!status.ok()) return NoteFailure(stage, status, context, &record);
  FREEGS_RETURN_IF_ERROR(PutInPlace(stage, context, &record));
  logger_.Log(LogLevel::kInfo, name + ": done in " + ToText(usage));
  return Status();
}

// Puts what the stage made in its place, with the record of its run.
Status StageRunner::PutInPlace(const RunnerStage& stage,
                               const StageContext& context,
                               StageRecord* record) {
  const std::string name = NameOf(stage);
  record->contents = StageContents(context.output);
  for (const std::string& file : stage.stage->Disposable()) {
    std::erase(record->contents, file);
  }
  logger_.SetTransient("");
  FREEGS_RETURN_IF_ERROR(FinishPartial(options_.workspace, name, *record));
  // Which files later stages read may depend on what is in place, such as
  // masks. Without the list nothing is compared with it, so no harm is done if
  // it cannot be written.
  const fs::path folder = StageFolder(options_.workspace, name);
  record->outputs = ListOutputFiles(folder, ReadLater(name));
  (void)WriteStageRecord(folder, *record);
  return Status();
}

// Writes down why the stage did not succeed. Returns it as the user is told.
Status StageRunner::NoteFailure(const RunnerStage& stage,
                                const Status& status,
                                const StageContext& context,
                                StageRecord* record) {
  const std::string name = NameOf(stage);
  // A child process that got the same Ctrl-C makes a stage fail in its own
  // words; it was an interruption all the same.
  const bool interrupted =
      status.code() == StatusCode::kInterrupted || cancellation_.cancelled();
  record->outcome =
      interrupted ? StageOutcome::kInterrupted : StageOutcome::kFailed;
  record->error_code = interrupted ? StatusCode::kInterrupted : status.code();
  record->error = status.message();
  // The stage's error matters more than one of writing it down.
  (void)WritePartialUsage(
      context.output,
      {record->wall_seconds, record->cpu_seconds, record->peak_memory_bytes});
  (void)WriteStageRecord(context.output, *record);
  logger_.LogToFile(LogLevel::kError, Prefixed(name, status.message()));
  return Status(
      record->error_code,
      FailureMessage(name, status, *record, options_.way_on, context.output));
}

}  // namespace freegs::pipeline
