// SPDX-License-Identifier: BSD-3-Clause

#include "stages/bench/stage_store.h"

#include <algorithm>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "stages/bench/cell_result.h"
#include "tests/temporary_folder.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

class StageStoreTest : public ::testing::Test {
 protected:
  StageStoreTest() {
    folder_.Write("photos/a.jpg", "one");
    folder_.Write("program", "#!/bin/sh\n");
    context_.out = folder_ / "out";
    context_.program = folder_ / "program";
    context_.say = [this](const std::string& text) { said_.push_back(text); };
    fs::create_directories(context_.out);
  }

  // The program is a script from now on.
  void UseScript(const std::string& lines) {
    folder_.Write("program", "#!/bin/sh\n" + lines);
    fs::permissions(folder_ / "program", fs::perms::owner_all);
  }

  CellPlan PlanOf(const SuiteCell& cell) {
    StageStore store(context_, "reconstruct");
    StatusOr<CellPlan> plan = store.Plan(
        cell, {folder_ / "photos", folder_ / "photos", folder_ / "photos"});
    EXPECT_TRUE(plan.ok()) << plan.status().message();
    return plan.ok() ? *plan : CellPlan();
  }

  static std::vector<std::string> Keys(const CellPlan& plan) {
    std::vector<std::string> keys;
    for (const StoredStage& stage : plan.stages) {
      keys.push_back(stage.workspace.filename().string());
    }
    return keys;
  }

  TemporaryFolder folder_;
  BenchContext context_;
  std::vector<std::string> said_;
};

TEST_F(StageStoreTest, CellsShareTheStagesBeforeTheFirstDifference) {
  SuiteCell cell;
  const std::vector<std::string> plain = Keys(PlanOf(cell));
  ASSERT_EQ(plain.size(), 4u);  // ingest, sfm, undistort, reconstruct
  EXPECT_EQ(Keys(PlanOf(cell)), plain);

  cell.settings = {{"reconstruct.iterations", "77"}};
  std::vector<std::string> keys = Keys(PlanOf(cell));
  EXPECT_EQ(keys[2], plain[2]);
  EXPECT_NE(keys[3], plain[3]);

  cell.settings = {{"sfm.max_features", "77"}};
  keys = Keys(PlanOf(cell));
  EXPECT_EQ(keys[0], plain[0]);
  EXPECT_NE(keys[1], plain[1]);
  EXPECT_NE(keys[3], plain[3]);

  // What concerns a later stage does not count.
  cell.settings = {{"bootstrap.granularity", "1"}};
  EXPECT_EQ(Keys(PlanOf(cell)), plain);

  // What changes only the time counts.
  cell.settings = {{"general.threads", "2"}};
  EXPECT_NE(Keys(PlanOf(cell))[0], plain[0]);
  cell.settings = {{"reconstruct.image_cache_gb", "0.1"}};
  keys = Keys(PlanOf(cell));
  EXPECT_EQ(keys[2], plain[2]);
  EXPECT_NE(keys[3], plain[3]);

  // A seed counts from the first stage that draws numbers.
  cell.settings = {};
  cell.seed = 5;
  keys = Keys(PlanOf(cell));
  EXPECT_EQ(keys[0], plain[0]);
  EXPECT_NE(keys[1], plain[1]);

  // Photographs count by what they hold.
  cell.seed = 0;
  folder_.Write("photos/a.jpg", "other");
  EXPECT_NE(Keys(PlanOf(cell))[0], plain[0]);
}

TEST_F(StageStoreTest, PhotosBehindALinkCountByContent) {
  folder_.Write("more/b.jpg", "one");
  fs::create_directory_symlink(folder_ / "more", folder_ / "photos" / "more");
  const std::vector<std::string> before = Keys(PlanOf({}));
  EXPECT_EQ(Keys(PlanOf({})), before);
  folder_.Write("more/b.jpg", "other");
  EXPECT_NE(Keys(PlanOf({}))[0], before[0]);
}

TEST_F(StageStoreTest, ImportedFilesCountByContent) {
  folder_.Write("model.json", "1");
  SuiteCell cell;
  cell.settings = {{"sfm.import", (folder_ / "model.json").string()}};
  const std::vector<std::string> before = Keys(PlanOf(cell));
  folder_.Write("model.json", "22");
  const std::vector<std::string> after = Keys(PlanOf(cell));
  EXPECT_EQ(before[0], after[0]);
  EXPECT_NE(before[1], after[1]);
}

TEST_F(StageStoreTest, SceneVariableIsTheFolderOfTheScene) {
  SuiteCell cell;
  cell.settings = {{"sfm.import", "${scene}/model"}};
  cell.eval_options["model"] = "${scene}/clip";
  const CellPlan plan = PlanOf(cell);
  EXPECT_EQ(plan.settings[0].second, (folder_ / "photos/model").string());
  EXPECT_EQ(plan.eval_options.at("model"), (folder_ / "photos/clip").string());
}

TEST_F(StageStoreTest, DisturbedPhotosAreMadeOnce) {
  int calls = 0;
  context_.disturber.changes_poses = [](const std::string&) { return false; };
  context_.disturber.disturb = [&calls](const std::string& text,
                                        const fs::path& images,
                                        const fs::path& out,
                                        uint64_t seed) {
    ++calls;
    fs::create_directories(out);
    WriteText(out / "a.jpg",
              ReadText(images / "a.jpg") + text + std::to_string(seed));
    return Status();
  };
  SuiteCell cell;
  const std::vector<std::string> plain = Keys(PlanOf(cell));
  cell.disturb = "blur:2";
  cell.seed = 3;
  const CellPlan plan = PlanOf(cell);
  EXPECT_NE(Keys(plan)[0], plain[0]);
  EXPECT_EQ(ReadText(plan.images / "a.jpg"), "oneblur:23");
  EXPECT_EQ(Keys(PlanOf(cell)), Keys(plan));
  EXPECT_EQ(calls, 1);
}

TEST_F(StageStoreTest, PhotosThatWereDisturbedInPartAreMadeAnew) {
  bool stop = true;
  context_.disturber.changes_poses = [](const std::string&) { return false; };
  context_.disturber.disturb =
      [&stop](
          const std::string&, const fs::path&, const fs::path& out, uint64_t) {
        EXPECT_FALSE(fs::exists(out / "a.jpg"));
        WriteText(out / "a.jpg", "a");
        if (stop) return InterruptedError("stopped");
        WriteText(out / "b.jpg", "b");
        return Status();
      };
  SuiteCell cell;
  cell.disturb = "blur:2";
  StageStore store(context_, "reconstruct");
  const auto stopped = store.Plan(
      cell, {folder_ / "photos", folder_ / "photos", folder_ / "photos"});
  EXPECT_EQ(stopped.status().code(), StatusCode::kInterrupted);
  stop = false;
  EXPECT_TRUE(fs::exists(PlanOf(cell).images / "b.jpg"));
}

TEST_F(StageStoreTest, DisturbedPosesAreThoseOfTheUndisturbedRun) {
  UseScript("exit 0\n");
  fs::path disturbed;
  context_.disturber.changes_poses = [](const std::string&) { return true; };
  context_.disturber.disturb = [&disturbed](const std::string&,
                                            const fs::path& model,
                                            const fs::path& out,
                                            uint64_t) {
    disturbed = model;
    WriteText(out / "cameras.txt", "moved");
    return Status();
  };
  SuiteCell cell;
  const std::vector<std::string> plain = Keys(PlanOf(cell));
  cell.disturb = "jitter:2";
  const CellPlan plan = PlanOf(cell);
  EXPECT_EQ(disturbed, context_.out / "store" / plain[1] / "sfm/sparse/0");
  EXPECT_EQ(Keys(plan)[0], plain[0]);
  EXPECT_NE(Keys(plan)[1], plain[1]);
  ASSERT_FALSE(plan.settings.empty());
  const auto import = std::find_if(
      plan.settings.begin(), plan.settings.end(), [](const auto& setting) {
        return setting.first == "sfm.import";
      });
  ASSERT_NE(import, plan.settings.end());
  EXPECT_EQ(ReadText(fs::path(import->second) / "cameras.txt"), "moved");

  // A run without poses has none to disturb.
  UseScript("echo 'freegs_pipeline: all dark'\nexit 4\n");
  cell.seed = 2;
  StageStore store(context_, "reconstruct");
  const auto failed = store.Plan(
      cell, {folder_ / "photos", folder_ / "photos", folder_ / "photos"});
  EXPECT_THAT(failed.status().message(), HasSubstr("all dark"));
}

TEST_F(StageStoreTest, FailuresOfTheMethodAreKeptOthersTriedAgain) {
  SuiteCell cell;
  const CellPlan plan = PlanOf(cell);
  const auto run = [&] {
    StageStore store(context_, "reconstruct");
    const StatusOr<ChildOutcome> outcome = store.RunStage(plan, 0);
    // A second cell with the same stage does not try it again.
    EXPECT_EQ(store.RunStage(plan, 0)->exit_code, outcome->exit_code);
    return *outcome;
  };
  const std::string count = "echo x >> " + (folder_ / "calls").string() + "\n";
  UseScript(count +
            "echo 'warning: dark photos'\n"
            "echo 'freegs_pipeline: sfm: no poses'\nexit 4\n");
  ChildOutcome outcome = run();
  EXPECT_EQ(outcome.exit_code, 4);
  EXPECT_EQ(outcome.reason, "sfm: no poses");
  EXPECT_THAT(
      outcome.said,
      ElementsAre("warning: dark photos", "freegs_pipeline: sfm: no poses"));
  EXPECT_EQ(run().exit_code, 4);
  EXPECT_EQ(ReadText(folder_ / "calls"), "x\n");

  fs::remove_all(context_.out / "store");
  UseScript(count + "exit 5\n");
  EXPECT_EQ(run().exit_code, 5);
  EXPECT_EQ(run().exit_code, 5);
  EXPECT_EQ(ReadText(folder_ / "calls"), "x\nx\nx\n");

  // A comparison with a baseline is about the program of now.
  fs::remove_all(context_.out / "store");
  UseScript(count + "exit 4\n");
  EXPECT_EQ(run().exit_code, 4);
  UseScript(count + "exit 3\n");
  EXPECT_EQ(run().exit_code, 4);
  context_.only_this_program = true;
  EXPECT_EQ(run().exit_code, 3);
}

TEST_F(StageStoreTest, OfManyWarningsAllKindsAreKept) {
  UseScript(
      "for x in a b c d e f g h i j k l; do echo \"warning: $x.jpg is 1\"; "
      "done\necho 'warning: a.jpg is 2'\nexit 4\n");
  const CellPlan plan = PlanOf({});
  StageStore store(context_, "reconstruct");
  const StatusOr<ChildOutcome> outcome = store.RunStage(plan, 0);
  ASSERT_TRUE(outcome.ok()) << outcome.status().message();
  const fs::path file = plan.stages[0].workspace / "outcome.json";
  const auto kept = ReadOutcome(file);
  ASSERT_TRUE(kept.ok()) << kept.status().message();
  for (const ChildOutcome& known : {*outcome, *kept}) {
    ASSERT_EQ(known.said.size(), 10u);
    EXPECT_EQ(known.said[4], "warning: e.jpg is 1");
    EXPECT_EQ(known.said[5], "warning: i.jpg is 1");
    EXPECT_EQ(known.said[9], "warning: a.jpg is 2");
    ASSERT_EQ(known.kinds.size(), 12u);
    EXPECT_EQ(known.kinds[0], "warning: a.jpg is 1");
    EXPECT_EQ(known.kinds[6], "warning: g.jpg is 1");
  }
  // What an earlier program wrote.
  WriteText(file,
            R"({"exit_code": 4, "reason": "", "timed_out": false,
                "said": ["warning: dark"], "program": "a"})");
  EXPECT_THAT(ReadOutcome(file)->kinds, ElementsAre("warning: dark"));
}

TEST(ChildOutcomeTest, LinesAreOfOneKindWhereOnlyNumbersDiffer) {
  EXPECT_EQ(KindOfLine("warning: 14 of 20 photos"), "warning: # of # photos");
  EXPECT_EQ(KindOfLine("warning: 0014/a2.jpg is dark"),
            "warning: a#.jpg is dark");
  EXPECT_EQ(KindOfLine("0014/b/a.jpg, '0015/7.jpg'"), "b/a.jpg, '#.jpg'");
  EXPECT_EQ(KindOfLine("b/14/a.jpg, b14/a.jpg"), "b/#/a.jpg, b#/a.jpg");
}

TEST_F(StageStoreTest, WhatAnotherProgramBeganDoesNotGoOn) {
  const CellPlan plan = PlanOf({});
  const fs::path folder = plan.stages[0].workspace;
  // The run is killed: it leaves a checkpoint and no outcome.
  fs::create_directories(folder);
  WriteText(folder / ".program", "another");
  WriteText(folder / "checkpoint", "");
  UseScript("exit 0\n");
  {
    StageStore store(context_, "reconstruct");
    EXPECT_THAT(store.RunStage(plan, 0)->programs, Contains("another"));
  }
  EXPECT_TRUE(fs::exists(folder / "checkpoint"));
  context_.only_this_program = true;
  StageStore store(context_, "reconstruct");
  EXPECT_THAT(store.RunStage(plan, 0)->programs, Not(Contains("another")));
  EXPECT_FALSE(fs::exists(folder / "checkpoint"));
}

TEST_F(StageStoreTest, WhatRestsOnAnotherProgramIsOfThatProgramToo) {
  const CellPlan plan = PlanOf({});
  const std::string count = "echo x >> " + (folder_ / "calls").string() + "\n";
  // Stage ingest is of one program, what follows of another.
  UseScript("exit 4\n");
  std::set<std::string> first;
  {
    StageStore store(context_, "reconstruct");
    first = store.RunStage(plan, 0)->programs;
    EXPECT_EQ(first.size(), 1u);
  }
  UseScript(count + "exit 4\n");
  std::set<std::string> second;
  {
    StageStore store(context_, "reconstruct");
    EXPECT_EQ(store.RunStage(plan, 0)->programs, first);
    second = store.RunStage(plan, 1)->programs;
    EXPECT_EQ(second.size(), 2u);
    EXPECT_THAT(second, Contains(*first.begin()));
    EXPECT_EQ(store.Evaluate(plan)->programs, second);
  }
  EXPECT_EQ(ReadText(folder_ / "calls"), "x\nx\n");
  // A comparison does all of it anew, and once.
  context_.only_this_program = true;
  second.erase(*first.begin());
  for (int i = 0; i < 2; ++i) {
    StageStore store(context_, "reconstruct");
    EXPECT_EQ(store.RunStage(plan, 0)->programs, second);
    EXPECT_EQ(store.RunStage(plan, 1)->programs, second);
    EXPECT_EQ(store.Evaluate(plan)->programs, second);
  }
  EXPECT_EQ(ReadText(folder_ / "calls"), "x\nx\nx\nx\nx\n");
}

TEST_F(StageStoreTest, AProgramThatIsBuiltAnewMeanwhileIsNoticed) {
  const CellPlan plan = PlanOf({});
  UseScript("exit 4\n");
  {
    StageStore store(context_, "reconstruct");
    const auto before = store.RunStage(plan, 0)->programs;
    UseScript("exit 3\n");
    const auto after = store.RunStage(plan, 1)->programs;
    EXPECT_EQ(after.size(), 2u);
    EXPECT_THAT(after, Contains(*before.begin()));
  }
  context_.only_this_program = true;
  StageStore store(context_, "reconstruct");
  ASSERT_TRUE(store.RunStage(plan, 0).ok());
  UseScript("exit 4\n");
  const Status status = store.RunStage(plan, 1).status();
  EXPECT_EQ(status.code(), StatusCode::kInternal);
  EXPECT_THAT(status.message(), HasSubstr("built anew"));
}

TEST_F(StageStoreTest, EvalIsToldWhetherPlanesMayAnswer) {
  UseScript("echo \"$@\" >> " + (folder_ / "calls").string() + "\nexit 4\n");
  SuiteCell cell;
  const CellPlan without = PlanOf(cell);
  cell.settings = {{"query.background", "true"}};
  const CellPlan with = PlanOf(cell);
  // The stages are shared, the figures are not.
  EXPECT_EQ(Keys(with), Keys(without));
  EXPECT_NE(with.evaluation, without.evaluation);
  for (const auto& [plan, value] :
       {std::pair(with, "true"), std::pair(without, "false")}) {
    StageStore store(context_, "reconstruct");
    ASSERT_TRUE(store.Evaluate(plan).ok());
    EXPECT_THAT(ReadText(folder_ / "calls"),
                HasSubstr(std::string("--query.background=") + value));
  }
}

TEST_F(StageStoreTest, ATimeLimitIsAFailure) {
  context_.time_limit_s = 0.2;
  UseScript("sleep 20\n");
  StageStore store(context_, "reconstruct");
  const StatusOr<ChildOutcome> outcome = store.RunStage(PlanOf({}), 0);
  ASSERT_TRUE(outcome.ok()) << outcome.status().message();
  EXPECT_THAT(outcome->reason, HasSubstr("no end within"));
  const auto kept =
      ReadOutcome(PlanOf({}).stages[0].workspace / "outcome.json");
  ASSERT_TRUE(kept.ok()) << kept.status().message();
  for (const ChildOutcome& known : {*outcome, *kept}) {
    EXPECT_TRUE(known.IsFinal(0.2));
    EXPECT_TRUE(known.IsFinal(0.1));
    EXPECT_FALSE(known.IsFinal(0.3));
    EXPECT_FALSE(known.IsFinal(0));
  }
  // A larger limit is another attempt.
  UseScript("exit 0\n");
  context_.time_limit_s = 20;
  StageStore longer(context_, "reconstruct");
  EXPECT_EQ(longer.RunStage(PlanOf({}), 0)->exit_code, 0);
}

TEST_F(StageStoreTest, CancellingEndsTheBench) {
  CancellationToken token;
  token.Cancel();
  context_.cancellation = &token;
  UseScript("sleep 20\n");
  StageStore store(context_, "reconstruct");
  EXPECT_EQ(store.RunStage(PlanOf({}), 0).status().code(),
            StatusCode::kInterrupted);
}

TEST_F(StageStoreTest, DamagedFilesOfAStageGiveNoFigures) {
  folder_.Write("w/sfm/metrics.json", "{\"a\": {\"b\": 1.5}, \"c\": true");
  folder_.Write("w/sfm/stage.json", "[]");
  CellResult result;
  AddStageFigures(folder_ / "w", "sfm", &result);
  EXPECT_EQ(result.values.count("sfm.a.b"), 0u);
  folder_.Write("w/sfm/metrics.json", "{\"a\": {\"b\": 1.5}, \"c\": true}");
  AddStageFigures(folder_ / "w", "sfm", &result);
  EXPECT_EQ(result.values["sfm.a.b"], 1.5);
  EXPECT_EQ(result.values["sfm.c"], 1);
  folder_.Write("eval.json", "{\"psnr\": 20, \"text_miou\": null, \"x\": [1]}");
  ASSERT_TRUE(AddEvaluation(folder_ / "eval.json", &result).ok());
  EXPECT_EQ(result.values["psnr"], 20);
  EXPECT_EQ(result.values.count("text_miou"), 0u);
  folder_.Write("eval.json", "{");
  EXPECT_FALSE(AddEvaluation(folder_ / "eval.json", &result).ok());
}

TEST_F(StageStoreTest, ScenesThatAreNotThereAreNamed) {
  SuiteScene scene;
  scene.name = "s";
  scene.images = folder_ / "none";
  EXPECT_THAT(FindScenePhotos(scene, context_).status().message(),
              HasSubstr("[scene s] images"));
  scene.images.clear();
  scene.draw = {"--views", "3"};
  const Status status = FindScenePhotos(scene, context_).status();
  EXPECT_EQ(status.code(), StatusCode::kMissingDependency);
  EXPECT_THAT(status.message(), HasSubstr("freegs_make_scene"));
  // One that fails.
  folder_.Write("freegs_make_scene", "#!/bin/sh\nexit 2\n");
  fs::permissions(folder_ / "freegs_make_scene", fs::perms::owner_all);
  EXPECT_EQ(FindScenePhotos(scene, context_).status().code(),
            StatusCode::kBadInput);
}

}  // namespace
}  // namespace freegs::stages
