// SPDX-License-Identifier: BSD-3-Clause
// Results of stages, shared by all cells of a bench to which they belong.
//
// OUT/store/STAGE_KEY is a workspace in which one stage has run; the folders of
// the stages before it are links to others of these workspaces. The key is made
// of everything that decides the result: the photographs, and the options of
// the stage and of those before it. So cells that differ only in later options
// share the earlier work, and a bench that was killed goes on where it was.

#ifndef FREEGS_STAGES_BENCH_STAGE_STORE_H_
#define FREEGS_STAGES_BENCH_STAGE_STORE_H_

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "core/status.h"
#include "pipeline/fingerprint.h"
#include "stages/bench/bench_context.h"
#include "stages/bench/child_outcome.h"
#include "stages/bench/scene_photos.h"
#include "stages/suite/suite_cells.h"

namespace freegs::stages {

// One stage of one cell.
struct StoredStage {
  std::string stage;
  std::filesystem::path workspace;  // OUT/store/STAGE_KEY
};

// Makes the link workspace / STAGE to a stage of the store, by a relative path.
// Both paths must be absolute.
Status LinkStage(const StoredStage& from,
                 const std::filesystem::path& workspace);

// The stages of a cell in their order, and how its photographs are processed.
struct CellPlan {
  std::filesystem::path images;
  std::filesystem::path truth;
  std::vector<SuiteSetting> settings;  // With seed, and without variables.
  std::vector<StoredStage> stages;
  std::map<std::string, std::string> eval_options;  // Without variables.
  std::filesystem::path evaluation;  // OUT/store/eval_KEY; empty for none.
};

// Several threads may use one store.
class StageStore {
 public:
  // `context` must outlive the store. `to` is the last stage.
  StageStore(const BenchContext& context, std::string to);

  // Finds out where the stages of a cell are stored, and makes its photographs
  // if they are to be disturbed. If its poses are, the poses of the cell
  // without the disturbance are found first, and imported when they are
  // disturbed.
  StatusOr<CellPlan> Plan(const SuiteCell& cell, const ScenePhotos& photos);

  // Brings stage `index` of the plan up to date; those before it must be. A
  // stage that failed in this bench, or earlier for a reason that stays
  // (ChildOutcome::IsFinal), is not tried again. kInterrupted when cancelled.
  StatusOr<ChildOutcome> RunStage(const CellPlan& plan, size_t index);

  // Brings the figures of eval up to date, which are about the last stage of
  // the plan, as RunStage does with a stage. They lie in plan.evaluation /
  // "eval.json".
  StatusOr<ChildOutcome> Evaluate(const CellPlan& plan);

  // Whether a plan's stage needs no more work.
  bool IsDone(const StoredStage& stage) const;

 private:
  StatusOr<CellPlan> PlanWithPoses(const SuiteCell& cell,
                                   const ScenePhotos& photos);
  StatusOr<std::filesystem::path> Disturb(const SuiteCell& cell,
                                          const DisturbSource& source);
  std::string Hash(const std::filesystem::path& path);

  // What the keys of disturbed photos and poses have of the program: its hash
  // where results of another program do not count.
  std::string ProgramOfKeys() const;

  // What an earlier bench left in `folder`. Deletes the folder when it rests on
  // a program whose results do not count.
  StatusOr<ChildOutcome> EarlierOutcome(const std::filesystem::path& folder);

  // Runs the command that `prepare` returns and keeps its outcome in `folder`,
  // unless an outcome that stays is there, together with its result
  // (`is_there`). Other threads that want the same folder wait. `programs` are
  // those that made what the command reads.
  using PrepareFn = std::function<StatusOr<std::vector<std::string>>()>;
  StatusOr<ChildOutcome> Once(const std::filesystem::path& folder,
                              std::set<std::string> programs,
                              const std::function<bool()>& is_there,
                              const PrepareFn& prepare);

  const BenchContext& context_;
  const std::string to_;
  const std::string program_hash_;
  std::mutex disturbing_;
  std::mutex mutex_;  // Guards what follows.
  pipeline::FingerprintCache cache_;
  std::map<std::filesystem::path, std::shared_ptr<std::mutex>> busy_;
  std::map<std::filesystem::path, ChildOutcome> known_;
};

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_BENCH_STAGE_STORE_H_
