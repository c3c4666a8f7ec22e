// SPDX-License-Identifier: BSD-3-Clause

#include "stages/bench/stage_store.h"

#include <algorithm>
#include <system_error>
#include <utility>

#include "core/io/files.h"
#include "photos/photo_scan.h"
#include "pipeline/exit_code.h"
#include "pipeline/stage_record.h"
#include "stages/registry/pipeline_options.h"
#include "stages/registry/stage_registry.h"
#include "stages/suite/ini_sections.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;

constexpr size_t kKeyDigits = 16;
constexpr char kOutcomeFile[] = "outcome.json";

// Holds the hashes of the programs that worked in a folder, and of those that
// made what it rests on.
constexpr char kProgramFile[] = ".program";

// Decides what `eval` says about labels.
constexpr char kBackgroundOption[] = "query.background";

// Parts of a key, apart by a byte that is in none of them.
class KeyBuilder {
 public:
  void Add(const std::string& part) { text_ += part + '\0'; }
  std::string Key() const { return HashBytes(text_).substr(0, kKeyDigits); }

 private:
  std::string text_;
};

// The value with the folder in place of ${scene}.
StatusOr<std::string> ExpandedValue(const std::string& value,
                                    const fs::path& scene_folder) {
  return ExpandVariables(value, [&](const std::string&) {
    return std::optional(scene_folder.string());
  });
}

StatusOr<std::vector<SuiteSetting>> ExpandedSettings(
    const SuiteCell& cell, const fs::path& scene_folder) {
  std::vector<SuiteSetting> settings;
  for (const auto& [name, value] : cell.settings) {
    FREEGS_ASSIGN_OR_RETURN(std::string expanded,
                            ExpandedValue(value, scene_folder));
    // What is set twice is set by the later one.
    std::erase_if(settings, [&name = name](const SuiteSetting& setting) {
      return setting.first == name;
    });
    settings.emplace_back(name, std::move(expanded));
  }
  settings.emplace_back("general.seed", std::to_string(cell.seed));
  return settings;
}

// Empty where it cannot be read.
std::string ProgramHash(const fs::path& program) {
  const StatusOr<std::string> hash = HashFile(program);
  return hash.ok() ? hash->substr(0, kKeyDigits) : "";
}

// The programs that the first `count` stages of a plan are of.
std::set<std::string> ProgramsOf(const CellPlan& plan, size_t count) {
  std::set<std::string> programs;
  for (size_t i = 0; i < count; ++i) {
    const StatusOr<std::string> text =
        ReadFile(plan.stages[i].workspace / kProgramFile);
    if (text.ok()) programs.merge(ParsePrograms(*text));
  }
  return programs;
}

}  // namespace

Status LinkStage(const StoredStage& from, const fs::path& workspace) {
  std::error_code error;
  const fs::path link = workspace / from.stage;
  const fs::path target =
      from.workspace.lexically_relative(workspace) / from.stage;
  if (fs::read_symlink(link, error) == target) return Status();
  fs::remove(link, error);
  fs::create_directory_symlink(target, link, error);
  if (!error) return Status();
  return InternalError(link.string() +
                       ": cannot make this link: " + error.message());
}

StageStore::StageStore(const BenchContext& context, std::string to)
    : context_(context),
      to_(std::move(to)),
      program_hash_(ProgramHash(context.program)),
      cache_(context.out, context.out / ".fingerprints.json") {}

std::string StageStore::Hash(const fs::path& path) {
  const std::lock_guard lock(mutex_);
  std::string hash = cache_.Hash(path).hash;
  // The cache does not follow links to folders; stage ingest does.
  const auto scan = photos::ScanPhotos(path, {context_.out});
  if (scan.ok()) {
    for (const std::string& link : scan->linked_folders) {
      hash += cache_.Hash(path / link).hash;
    }
  }
  // Without its cache the next bench only takes longer.
  (void)cache_.Save();
  return hash;
}

StatusOr<fs::path> StageStore::Disturb(const SuiteCell& cell,
                                       const DisturbSource& source) {
  // One at a time: another cell may want the same.
  const std::lock_guard lock(disturbing_);
  return Disturbed(
      source, cell.disturb, static_cast<uint64_t>(cell.seed), context_);
}

StatusOr<CellPlan> StageStore::PlanWithPoses(const SuiteCell& cell,
                                             const ScenePhotos& photos) {
  SuiteCell other = cell;
  other.disturb.clear();
  FREEGS_ASSIGN_OR_RETURN(const CellPlan undisturbed, Plan(other, photos));
  for (size_t i = 0; i < undisturbed.stages.size(); ++i) {
    const StoredStage& stage = undisturbed.stages[i];
    FREEGS_ASSIGN_OR_RETURN(const ChildOutcome outcome,
                            RunStage(undisturbed, i));
    if (!outcome.ok()) {
      return UnusableResultError(
          "there are no poses to disturb: without the disturbance stage " +
          stage.stage + " fails: " + outcome.reason);
    }
    if (stage.stage != "sfm") continue;
    const fs::path model = stage.workspace / "sfm" / "sparse" / "0";
    FREEGS_ASSIGN_OR_RETURN(
        const fs::path poses,
        Disturb(cell, {model, Hash(model) + ProgramOfKeys(), "poses"}));
    other.settings.emplace_back("sfm.import", poses.string());
    return Plan(other, photos);
  }
  return InvalidArgumentError("[suite] to: stage sfm has to be run");
}

StatusOr<CellPlan> StageStore::Plan(const SuiteCell& cell,
                                    const ScenePhotos& photos) {
  if (!cell.disturb.empty() && context_.disturber.changes_poses(cell.disturb)) {
    return PlanWithPoses(cell, photos);
  }
  CellPlan plan;
  plan.truth = photos.truth;
  FREEGS_ASSIGN_OR_RETURN(plan.settings, ExpandedSettings(cell, photos.folder));
  plan.images = photos.images;
  if (!cell.disturb.empty()) {
    FREEGS_ASSIGN_OR_RETURN(
        plan.images,
        Disturb(
            cell,
            {photos.images, Hash(photos.images) + ProgramOfKeys(), "photos"}));
  }
  PipelineOptions options;
  pipeline::OptionTable table = MakeOptionTable(&options);
  std::vector<pipeline::OptionSetting> settings;
  for (const auto& [name, value] : plan.settings) {
    settings.push_back({name, value, cell.id});
  }
  // There is no config.ini in the store.
  FREEGS_RETURN_IF_ERROR(
      ApplySettings(context_.out / "store", settings, table));
  KeyBuilder key;
  key.Add(Hash(plan.images));
  // The time of a stage is measured, too. So options count that do not change
  // its result but may change its time.
  for (const char* cost : {"general.threads", "general.checkpoint_interval"}) {
    key.Add(table.Find(cost)->value());
  }
  bool has_scene = false;
  for (const pipeline::RunnerStage& entry : MakeStages(options, table)) {
    const std::string name(entry.stage->name());
    key.Add(name);
    key.Add(std::to_string(entry.stage->version()));
    for (const auto& [option, value] : entry.options) {
      key.Add(option);
      key.Add(value);
    }
    // Files that options name count by their content.
    for (const auto& [option, value] : entry.other_options) {
      const bool is_file = table.Find(option)->spec.is_path && !value.empty();
      key.Add(option);
      key.Add(is_file ? Hash(value) : value);
    }
    plan.stages.push_back(
        {name, context_.out / "store" / (name + "_" + key.Key())});
    has_scene = has_scene || name == "reconstruct";
    if (name == to_) break;
  }
  if (has_scene) {
    key.Add(plan.truth.empty() ? "" : Hash(plan.truth));
    std::map<std::string, std::string> eval_options = cell.eval_options;
    // Always given, because the workspace of a stage may remember the value of
    // another cell.
    eval_options.emplace(kBackgroundOption,
                         table.Find(kBackgroundOption)->value());
    for (const auto& [option, value] : eval_options) {
      FREEGS_ASSIGN_OR_RETURN(const std::string expanded,
                              ExpandedValue(value, photos.folder));
      key.Add(option);
      key.Add(option == "model" ? Hash(expanded) : expanded);
      plan.eval_options[option] = expanded;
    }
    plan.evaluation = context_.out / "store" / ("eval_" + key.Key());
  }
  return plan;
}

bool StageStore::IsDone(const StoredStage& stage) const {
  const StatusOr<pipeline::StageRecord> record =
      pipeline::ReadStageRecord(stage.workspace / stage.stage);
  return record.ok() && record->outcome == pipeline::StageOutcome::kDone &&
         ReadOutcome(stage.workspace / kOutcomeFile).ok();
}

std::string StageStore::ProgramOfKeys() const {
  return context_.only_this_program ? program_hash_ : "";
}

StatusOr<ChildOutcome> StageStore::EarlierOutcome(const fs::path& folder) {
  StatusOr<ChildOutcome> outcome = ReadOutcome(folder / kOutcomeFile);
  if (!context_.only_this_program) return outcome;
  // What was interrupted has no outcome yet, but goes on from a checkpoint.
  const StatusOr<std::string> programs = ReadFile(folder / kProgramFile);
  if (programs.ok() && *programs == program_hash_) return outcome;
  std::error_code error;
  fs::remove_all(folder, error);
  return BadInputError(folder.string() + ": of another program");
}

StatusOr<ChildOutcome> StageStore::Once(const fs::path& folder,
                                        std::set<std::string> programs,
                                        const std::function<bool()>& is_there,
                                        const PrepareFn& prepare) {
  std::shared_ptr<std::mutex> busy;
  {
    const std::lock_guard lock(mutex_);
    std::shared_ptr<std::mutex>& entry = busy_[folder];
    if (entry == nullptr) entry = std::make_shared<std::mutex>();
    busy = entry;
  }
  // Another cell may be at the same work.
  const std::lock_guard working(*busy);
  {
    const std::lock_guard lock(mutex_);
    const auto known = known_.find(folder);
    if (known != known_.end()) return known->second;
  }
  const StatusOr<ChildOutcome> earlier = EarlierOutcome(folder);
  if (earlier.ok() && earlier->IsFinal(context_.time_limit_s) &&
      (!earlier->ok() || is_there())) {
    return *earlier;
  }
  FREEGS_RETURN_IF_ERROR(CreateFolders(folder));
  // Command run refuses a folder that holds other files before it is a
  // workspace.
  std::error_code ignored;
  fs::remove(folder / kOutcomeFile, ignored);
  // It may have been built anew since the bench began.
  const std::string program = ProgramHash(context_.program);
  if (context_.only_this_program && program != program_hash_) {
    return InternalError(context_.program.string() +
                         ": was built anew during the comparison; start it "
                         "again");
  }
  programs.insert(program);
  const StatusOr<std::string> began = ReadFile(folder / kProgramFile);
  if (began.ok()) programs.merge(ParsePrograms(*began));
  FREEGS_RETURN_IF_ERROR(
      WriteFileAtomic(folder / kProgramFile, ProgramsText(programs)));
  FREEGS_ASSIGN_OR_RETURN(const std::vector<std::string> argv, prepare());
  FREEGS_ASSIGN_OR_RETURN(ChildOutcome outcome, RunForOutcome(argv, context_));
  if (outcome.exit_code == pipeline::ExitCode(StatusCode::kInterrupted)) {
    return InterruptedError("interrupted; the same command goes on");
  }
  outcome.programs = std::move(programs);
  FREEGS_RETURN_IF_ERROR(WriteOutcome(folder / kOutcomeFile, outcome));
  const std::lock_guard lock(mutex_);
  known_[folder] = outcome;
  return outcome;
}

StatusOr<ChildOutcome> StageStore::RunStage(const CellPlan& plan,
                                            size_t index) {
  const StoredStage& stage = plan.stages[index];
  const auto prepare = [&]() -> StatusOr<std::vector<std::string>> {
    for (size_t i = 0; i < index; ++i) {
      FREEGS_RETURN_IF_ERROR(LinkStage(plan.stages[i], stage.workspace));
    }
    std::vector<std::string> argv = {context_.program.string(),
                                     "run",
                                     plan.images.string(),
                                     stage.workspace.string(),
                                     "--from=" + stage.stage,
                                     "--to=" + stage.stage};
    for (const auto& [name, value] : plan.settings) {
      argv.push_back("--" + name + "=" + value);
    }
    return argv;
  };
  return Once(
      stage.workspace,
      ProgramsOf(plan, index),
      [&] { return IsDone(stage); },
      prepare);
}

StatusOr<ChildOutcome> StageStore::Evaluate(const CellPlan& plan) {
  const fs::path file = plan.evaluation / "eval.json";
  const auto prepare = [&]() -> StatusOr<std::vector<std::string>> {
    std::vector<std::string> argv = {context_.program.string(),
                                     "eval",
                                     plan.stages.back().workspace.string(),
                                     "--json=" + file.string()};
    if (!plan.truth.empty()) argv.push_back("--gt=" + plan.truth.string());
    for (const auto& [option, value] : plan.eval_options) {
      argv.push_back("--" + option + "=" + value);
    }
    for (const auto& [name, value] : plan.settings) {
      if (name == "general.threads") {
        argv.push_back("--" + name + "=" + value);
      }
    }
    return argv;
  };
  const auto is_there = [&] {
    std::error_code error;
    return fs::exists(file, error);
  };
  return Once(
      plan.evaluation, ProgramsOf(plan, plan.stages.size()), is_there, prepare);
}

}  // namespace freegs::stages
