// SPDX-License-Identifier: BSD-3-Clause

#include "pipeline/stage_state.h"

#include <algorithm>
#include <system_error>
#include <utility>
#include <vector>

#include "core/io/json_text.h"
#include "core/text.h"
#include "pipeline/stage_output.h"
#include "pipeline/workspace.h"

namespace freegs::pipeline {
namespace {

namespace fs = std::filesystem;

// Whether an input is missing, cannot be read, or is a folder that held files
// and is empty now, as where a disk is not mounted.
bool IsGone(const InputFingerprint& now, const InputFingerprint* before) {
  return now.missing() || now.hash == "unreadable" ||
         (now.files == 0 && before != nullptr && before->files > 0);
}

bool LiesIn(const fs::path& inner, const fs::path& outer) {
  const fs::path relative = inner.lexically_relative(outer);
  return !relative.empty() && *relative.begin() != "..";
}

// The way from the workspace to an input. Where the record of an older program
// does not have it, the absolute path.
const std::string& FromWorkspace(const InputFingerprint& input) {
  return input.from_workspace.empty() ? input.path : input.from_workspace;
}

// Whether the stage read the input at the path where it is looked for now, or
// files in a folder at this path. When a workspace is moved, an absolute path
// stays, and a relative one in its config.ini leads elsewhere, so it is enough
// that one of the two is the same. Where a record does not say where an input
// lay, it is known by its name.
bool WasReadThere(const StageFingerprint& then,
                  const std::string& name,
                  const InputFingerprint& now) {
  return std::any_of(
      then.inputs.begin(), then.inputs.end(), [&](const auto& entry) {
        const InputFingerprint& input = entry.second;
        if (input.path.empty()) return entry.first == name;
        return LiesIn(input.path, now.path) ||
               LiesIn(FromWorkspace(input), FromWorkspace(now));
      });
}

// Which inputs count as gone.
enum class GoneRule {
  kWasReadThere,  // Those that were read at the same path.
  kAny,           // All that are not there, also those that never were.
};

// Whether an input of a record lay in one that is gone now. Where a record does
// not say where they lay, all did.
bool LayIn(const InputFingerprint& input, const InputFingerprint& gone) {
  if (gone.path.empty()) return true;
  return !input.path.empty() &&
         (LiesIn(input.path, gone.path) ||
          LiesIn(FromWorkspace(input), FromWorkspace(gone)));
}

// Given inputs that are gone are set to what they were; returns their names.
// Once one of them is gone, inputs that the stage finds in it, such as the
// targets of links, are not named any more: these are set to what they were,
// too.
std::vector<std::string> KeepGoneInputs(const StageFingerprint& then,
                                        GoneRule rule,
                                        CurrentInputs* now) {
  const auto& before = then.inputs;
  auto& inputs = now->fingerprint.inputs;
  std::vector<std::string> gone;
  std::vector<InputFingerprint> places;  // Of those that are gone.
  for (const std::string& name : now->given) {
    const auto old = before.find(name);
    if (!IsGone(inputs[name], old == before.end() ? nullptr : &old->second)) {
      continue;
    }
    if (rule == GoneRule::kWasReadThere &&
        !WasReadThere(then, name, inputs[name])) {
      continue;
    }
    if (old == before.end()) {
      // A folder of which the stage knew the files while it was there.
      places.push_back(inputs[name]);
      inputs.erase(name);
    } else if (!old->second.missing()) {
      places.push_back(old->second);
      inputs[name] = old->second;
    } else {
      continue;
    }
    gone.push_back(name);
  }
  for (const auto& entry : before) {
    if (std::any_of(places.begin(), places.end(), [&](const auto& place) {
          return rule == GoneRule::kAny || LayIn(entry.second, place);
        })) {
      inputs.insert(entry);
    }
  }
  return gone;
}

// "input photos is gone", where `state` is "gone".
std::string StateText(const std::vector<std::string>& inputs,
                      const std::string& state) {
  return inputs.size() == 1 ? "input " + inputs[0] + " is " + state
                            : "inputs " + Joined(inputs) + " are " + state;
}

// Says which inputs are missing, if a run that began with them could go on if
// they were back. Empty if not. A mistyped path must not cost what was saved,
// so it does not matter where the inputs lay.
std::string WaitsFor(const StageFingerprint& begun, CurrentInputs now) {
  const std::vector<std::string> gone =
      KeepGoneInputs(begun, GoneRule::kAny, &now);
  if (gone.empty() || !Difference(begun, now.fingerprint).empty()) return "";
  return StateText(gone, "missing") +
         "; what an interrupted run saved is kept until " +
         (gone.size() == 1 ? "it is" : "they are") + " there again";
}

// Whether an input lies elsewhere than the record says.
bool HasMoved(const StageFingerprint& then, const StageFingerprint& now) {
  return std::any_of(
      now.inputs.begin(), now.inputs.end(), [&](const auto& input) {
        const auto old = then.inputs.find(input.first);
        return old != then.inputs.end() &&
               (old->second.path != input.second.path ||
                old->second.from_workspace != input.second.from_workspace);
      });
}

// Names what the stage made and somebody deleted: "masks, scene.ply".
std::string DeletedContents(const fs::path& folder, const StageRecord& result) {
  const std::vector<std::string> now = StageContents(folder);
  std::vector<std::string> deleted;
  for (const std::string& name : result.contents) {
    if (!std::binary_search(now.begin(), now.end(), name)) {
      deleted.push_back(name);
    }
  }
  return Joined(deleted);
}

// Returns why the stage must write its output again, because somebody deleted
// files that later stages read; empty if it need not. Notes files that somebody
// replaced, and others that are gone.
std::string CheckOutput(const fs::path& workspace,
                        const std::string& stage,
                        const StageRecord& result,
                        const std::vector<fs::path>& read_later,
                        std::string* note) {
  const fs::path folder = StageFolder(workspace, stage);
  OutputChange change;
  if (!result.outputs.empty()) {
    change =
        CompareOutputFiles(result.outputs, ListOutputFiles(folder, read_later));
  }
  if (!change.missing.empty()) return change.missing + ": missing or empty";
  const auto add = [&](const std::string& names, const std::string& state) {
    if (names.empty()) return;
    *note += (note->empty() ? "" : "; ") + names + ": " + state +
             " (to make it again: freegs_pipeline stage " + stage + " " +
             ShellWord(workspace.string()) + ")";
  };
  add(change.replaced, "not as the stage wrote it, used as it is");
  add(DeletedContents(folder, result), "deleted");
  return "";
}

// The relative path that leads from the workspace to `path`; both are absolute.
// Links on the way are followed, so that it is the same for a workspace that is
// reached through a link. The last name may be that of a link: it stays,
// because that link may be gone another time. Empty if the way cannot be found.
fs::path WayTo(const fs::path& workspace, const fs::path& path) {
  std::error_code error;
  const fs::path plain = path.lexically_normal();
  const fs::path folder = fs::relative(plain.parent_path(), workspace, error);
  if (error) return {};
  return (folder / plain.filename()).lexically_normal();
}

}  // namespace

CurrentInputs GatherInputs(const RunnerStage& stage,
                           const StageContext& context,
                           FingerprintCache& cache) {
  CurrentInputs now;
  now.fingerprint.stage = stage.stage->name();
  now.fingerprint.version = stage.stage->version();
  for (const auto& [name, value] : stage.options) {
    now.fingerprint.options[name] = ValidUtf8(value);
  }
  for (const fs::path& input : stage.stage->Inputs(context)) {
    // Not the whole workspace, when no photo folder was ever given.
    if (input.empty()) continue;
    const fs::path path = context.workspace / input;
    std::string name = DisplayPath(context.workspace, path);
    const bool external = fs::path(name).is_absolute();
    if (input == context.images) {
      name = "photos";
    } else if (external) {
      // A folder may have been given as "model/".
      const fs::path full(name);
      name =
          (full.has_filename() ? full : full.parent_path()).filename().string();
    }
    name = ValidUtf8(name);
    while (now.fingerprint.inputs.contains(name)) name += "'";
    InputFingerprint& fingerprint = now.fingerprint.inputs[name];
    fingerprint = cache.Hash(path);
    // Stages name what other stages make relative to the workspace.
    if (!input.is_absolute()) continue;
    now.given.insert(name);
    const fs::path plain = path.has_filename() ? path : path.parent_path();
    fingerprint.path = ValidUtf8(DisplayPath(context.workspace, plain));
    if (external) {
      fingerprint.from_workspace =
          ValidUtf8(WayTo(context.workspace, plain).string());
    }
  }
  return now;
}

const char* StageStatusName(StageStatus status) {
  switch (status) {
    case StageStatus::kMissing:
      return "missing";
    case StageStatus::kDone:
      return "done";
    case StageStatus::kStale:
      return "stale";
    case StageStatus::kInterrupted:
      return "interrupted";
    case StageStatus::kFailed:
      return "failed";
    case StageStatus::kForeign:
      return "foreign";
  }
  return "";
}

// A run that failed for a reason outside the stage (a full disk, no memory, a
// missing program) goes on from what it saved, however often that happens: a
// stage itself leaves out checkpoints that it cannot read. Other failures are
// verdicts of the stage, which may come from what it saved.
bool IsWorthContinuing(const StageRecord& failed) {
  return failed.error_code == StatusCode::kMissingDependency ||
         failed.error_code == StatusCode::kInternal;
}

namespace {

// What an unfinished run left.
struct Unfinished {
  bool there = false;
  std::string difference;  // From what a run has now; empty: it can go on.
  bool failed = false;
};

// Notes in the state what the run wrote down, and which inputs it waits for.
Unfinished InspectPartial(const fs::path& partial,
                          const CurrentInputs& now,
                          StageState* state) {
  Unfinished unfinished;
  std::error_code error;
  if (!fs::exists(partial, error)) return unfinished;
  unfinished.there = true;
  const StatusOr<StageFingerprint> begun = ReadPartialFingerprint(partial);
  unfinished.difference = begun.ok() ? Difference(*begun, now.fingerprint)
                                     : "what it left is incomplete";
  StatusOr<StageRecord> attempt = ReadStageRecord(partial);
  if (attempt.ok()) state->attempt = *std::move(attempt);
  if (begun.ok()) state->waits_for = WaitsFor(*begun, now);
  unfinished.failed =
      state->attempt && state->attempt->outcome == StageOutcome::kFailed;
  if (unfinished.failed && !IsWorthContinuing(*state->attempt)) {
    state->waits_for.clear();
  }
  return unfinished;
}

// Returns why the result of the last finished run does not hold any more, or
// nothing if it does. Notes in the state what was found.
std::string InspectResult(const fs::path& workspace,
                          const std::string& stage,
                          const CurrentInputs& now,
                          const std::vector<fs::path>& read_later,
                          StageState* state) {
  StatusOr<StageRecord> result = ReadStageRecord(StageFolder(workspace, stage));
  if (!result.ok() || result->outcome != StageOutcome::kDone) {
    return "its stage.json is damaged";
  }
  CurrentInputs expected = now;
  const std::vector<std::string> gone =
      KeepGoneInputs(result->fingerprint, GoneRule::kWasReadThere, &expected);
  std::string difference =
      Difference(result->fingerprint, expected.fingerprint);
  std::string output_note;
  if (difference.empty()) {
    difference =
        CheckOutput(workspace, stage, *result, read_later, &output_note);
    state->lacks_files = !difference.empty();
    state->inputs_moved = HasMoved(result->fingerprint, expected.fingerprint);
    result->fingerprint = std::move(expected.fingerprint);
  }
  if (!gone.empty()) {
    const std::string them = gone.size() == 1 ? "it" : "them";
    state->note =
        StateText(gone, "gone") +
        (difference.empty()
             ? "; keeping the result made from " + them
             : ", and the stage cannot be made again without " + them +
                   "; --from with a later stage builds on the "
                   "result that there is");
  }
  if (!output_note.empty()) {
    state->note += (state->note.empty() ? "" : "; ") + output_note;
  }
  state->result = *std::move(result);
  return difference;
}

}  // namespace

StageState InspectStage(const fs::path& workspace,
                        const std::string& stage,
                        const CurrentInputs& now,
                        const std::vector<fs::path>& read_later) {
  StageState state;
  const Unfinished unfinished =
      InspectPartial(PartialFolder(workspace, stage), now, &state);
  const bool continuable = unfinished.there && unfinished.difference.empty();
  if (continuable && !unfinished.failed) {
    state.status = StageStatus::kInterrupted;
    state.reason = "continuing an interrupted run";
    state.resumable = true;
  }

  std::error_code error;
  const fs::path folder = StageFolder(workspace, stage);
  const bool finished = fs::exists(folder, error);
  if (finished && !fs::exists(RecordPath(folder), error)) {
    state.status = StageStatus::kForeign;
    state.reason =
        "the folder " + folder.string() +
        " was not made by this program (it has no stage.json): build on it "
        "with --from and the next stage, or delete it";
    state.resumable = false;
    return state;
  }
  std::string result_difference;
  if (finished) {
    result_difference =
        InspectResult(workspace, stage, now, read_later, &state);
  }

  if (state.resumable) return state;
  if (!result_difference.empty() && !unfinished.difference.empty() &&
      !unfinished.failed && state.waits_for.empty()) {
    state.note +=
        (state.note.empty() ? "" : "; ") +
        ("what an interrupted run of it saved does not fit any more (" +
         unfinished.difference + ") and goes when the stage runs again");
  }
  if (finished && result_difference.empty()) {
    state.status = StageStatus::kDone;
  } else if (unfinished.failed) {
    state.status = StageStatus::kFailed;
    state.reason = state.attempt->error;
    state.resumable = continuable && IsWorthContinuing(*state.attempt);
  } else if (finished) {
    state.status = StageStatus::kStale;
    state.reason = result_difference;
  } else if (unfinished.there) {
    state.status = StageStatus::kInterrupted;
    state.reason =
        "an interrupted run cannot be continued: " + unfinished.difference;
  } else {
    state.reason = "not run yet";
  }
  if (!state.waits_for.empty() && state.status != StageStatus::kDone) {
    state.reason = state.waits_for;
  }
  return state;
}

}  // namespace freegs::pipeline
