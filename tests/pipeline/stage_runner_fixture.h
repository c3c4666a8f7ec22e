// SPDX-License-Identifier: BSD-3-Clause
// A runner with three stages that only write text, and that do what a test
// says.

#ifndef FREEGS_TESTS_PIPELINE_STAGE_RUNNER_FIXTURE_H_
#define FREEGS_TESTS_PIPELINE_STAGE_RUNNER_FIXTURE_H_

#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "pipeline/logger.h"
#include "pipeline/stage_runner.h"
#include "pipeline/workspace.h"
#include "tests/temporary_folder.h"

namespace freegs::pipeline {

// What a test wants of a stage, and what the stage saw.
struct Script {
  int version = 1;
  std::string option = "1";
  std::vector<std::filesystem::path> inputs;
  std::filesystem::path optional_input;      // Read if it is there.
  std::function<Status(StageContext&)> act;  // Before the output is written.
  std::function<void()> asked;               // Which inputs there are.
  std::function<StageNeed(const StageContext&)> need;  // But its disk_bytes.
  int runs = 0;
  bool resumed = false;
  double earlier_seconds = 0;
  double earlier_cpu_seconds = 0;
};

class TextStage : public Stage {
 public:
  TextStage(std::string name, Script* script)
      : name_(std::move(name)), script_(script) {}
  std::string_view name() const override { return name_; }
  int version() const override { return script_->version; }
  std::vector<std::filesystem::path> Inputs(
      const StageContext& context) const override {
    if (script_->asked) script_->asked();
    std::vector<std::filesystem::path> inputs = script_->inputs;
    if (name_ == "a") inputs.push_back(context.images);
    const std::filesystem::path& optional = script_->optional_input;
    if (!optional.empty() &&
        std::filesystem::exists(context.workspace / optional)) {
      inputs.push_back(optional);
    }
    return inputs;
  }
  // Each stage makes one more Gaussian; one that is done makes ten.
  StageNeed Foretell(const StageContext& context,
                     bool done,
                     SceneOutlook* scene) const override {
    StageNeed need = script_->need ? script_->need(context) : StageNeed{};
    need.disk_bytes = scene->gaussians;
    scene->gaussians += done ? 10 : 1;
    return need;
  }
  std::vector<std::string> Disposable() const override { return {"cache"}; }
  Status Run(StageContext& context) override {
    ++script_->runs;
    script_->resumed = context.resuming;
    script_->earlier_seconds = context.earlier_seconds;
    script_->earlier_cpu_seconds = context.earlier_cpu_seconds;
    context.progress({"writing", 1, 2, ""});
    if (script_->act) FREEGS_RETURN_IF_ERROR(script_->act(context));
    WriteText(context.output / "out.txt", name_ + script_->option);
    context.summary["letters"] = 2;
    return Status();
  }

 private:
  std::string name_;
  Script* script_;
};

class StageRunnerTest : public ::testing::Test {
 protected:
  StageRunnerTest() {
    std::filesystem::create_directory(workspace());
    WriteText(images() / "1.jpg", "photo");
    b_.inputs = {"a/out.txt"};
    c_.inputs = {"b/out.txt"};
  }

  std::filesystem::path workspace() const { return workspace_; }
  std::filesystem::path images() const { return images_; }

  // With `forced`, only this stage is run.
  StageRunner MakeRunner(Logger* logger, const std::string& forced = "") {
    std::vector<RunnerStage> stages;
    for (auto& [name, script] : {std::pair{"a", &a_}, {"b", &b_}, {"c", &c_}}) {
      RunnerStage stage;
      stage.stage = std::make_unique<TextStage>(name, script);
      stage.options = {{std::string(name) + ".option", script->option}};
      stages.push_back(std::move(stage));
    }
    StageRunnerOptions options;
    options.workspace = workspace();
    options.images = images();
    options.from = forced.empty() ? from_ : forced;
    options.to = forced.empty() ? to_ : forced;
    options.forced = forced.empty() ? forced_ : forced;
    options.deadline = deadline_;
    options.num_threads = 1;
    options.usage_interval_seconds = 0;
    return StageRunner(
        std::move(stages), std::move(options), *cancellation_, *logger);
  }

  Status Run(const std::string& forced = "") {
    cancellation_ = std::make_unique<CancellationToken>();
    std::ostringstream console;
    Logger logger(console, /*terminal=*/false, "");
    const Status status = MakeRunner(&logger, forced).Run();
    log_ = console.str();
    return status;
  }

  std::vector<StageReport> Inspect() {
    cancellation_ = std::make_unique<CancellationToken>();
    std::ostringstream console;
    Logger logger(console, /*terminal=*/false, "");
    return MakeRunner(&logger).Inspect();
  }

  std::string Runs() const {
    return std::to_string(a_.runs) + std::to_string(b_.runs) +
           std::to_string(c_.runs);
  }

  // Runs b until it has written half of its work, then dies the way kill -9
  // does: nothing after the act is done. Returns the state it left.
  void KillDuringB() {
    b_.act = [this](StageContext& context) {
      WriteText(context.output / "checkpoint", "half");
      std::filesystem::copy(workspace(),
                            folder_ / "killed",
                            std::filesystem::copy_options::recursive);
      return Status();
    };
    EXPECT_TRUE(Run().ok());
    b_.act = nullptr;
    std::filesystem::remove_all(workspace());
    std::filesystem::rename(folder_ / "killed", workspace());
  }

  TemporaryFolder folder_;
  std::filesystem::path workspace_ = folder_ / "ws";
  std::filesystem::path images_ = folder_ / "photos";
  Script a_, b_, c_;
  std::string from_, to_;
  std::string forced_;  // Run again together with the stages after it.
  std::optional<std::chrono::steady_clock::time_point> deadline_;
  std::string log_;
  std::unique_ptr<CancellationToken> cancellation_ =
      std::make_unique<CancellationToken>();
};

}  // namespace freegs::pipeline

#endif  // FREEGS_TESTS_PIPELINE_STAGE_RUNNER_FIXTURE_H_
