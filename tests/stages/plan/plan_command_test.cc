// SPDX-License-Identifier: BSD-3-Clause

#include "stages/plan/plan_command.h"

#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "pipeline/logger.h"
#include "pipeline/stage_runner.h"
#include "pipeline/workspace.h"
#include "stages/registry/pipeline_options.h"
#include "stages/registry/stage_registry.h"
#include "tests/photos/photo_test_files.h"
#include "tests/temporary_folder.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::HasSubstr;

class PlanCommandTest : public ::testing::Test {
 protected:
  void SetUp() override {
    for (int i = 0; i < 6; ++i) {
      folder_.Write("photos/" + std::to_string(i) + ".jpg",
                    photos::MakeJpeg(64, 48, i));
    }
  }

  Status Call(std::vector<std::string> arguments) {
    std::ostringstream out;
    const Status status = RunPlan(arguments, out, {});
    out_ = out.str();
    return status;
  }

  json Plan(std::vector<std::string> arguments) {
    arguments.emplace_back("--json");
    const Status status = Call(std::move(arguments));
    EXPECT_TRUE(status.ok()) << status.message();
    return json::parse(out_);
  }

  std::string Path(const std::string& name) const {
    return (folder_ / name).string();
  }

  TemporaryFolder folder_;
  std::string out_;
};

TEST_F(PlanCommandTest, PhotosAreEnough) {
  const json plan =
      Plan({Path("new"), "--images", Path("photos"), "--general.threads", "3"});
  EXPECT_FALSE(fs::exists(folder_ / "new"));
  EXPECT_EQ(plan["workspace"], Path("new"));
  EXPECT_EQ(plan["threads"], 3);
  EXPECT_TRUE(plan["program"].is_string());
  ASSERT_EQ(plan["stages"].size(), 6u);
  double seconds = 0;
  int64_t memory = 0;
  int64_t disk = 0;
  for (size_t i = 0; i < 6; ++i) {
    const json& stage = plan["stages"][i];
    EXPECT_EQ(stage["name"], StageNames()[i]);
    EXPECT_EQ(stage["state"], "needed");
    EXPECT_EQ(stage["reason"], "not run yet");
    EXPECT_EQ(stage["threads"], 3);
    EXPECT_EQ(stage["known"], true);
    EXPECT_EQ(stage["from_files"], i == 0);
    EXPECT_GT(stage["seconds"], 0);
    EXPECT_NE(stage["advice"], "");
    seconds += stage["seconds"].get<double>();
    memory = std::max(memory, stage["memory_bytes"].get<int64_t>());
    disk += stage["disk_bytes"].get<int64_t>();
  }
  EXPECT_NEAR(plan["total"]["seconds"].get<double>(), seconds, 1e-9);
  EXPECT_EQ(plan["total"]["memory_bytes"], memory);
  EXPECT_EQ(plan["total"]["disk_bytes"], disk);

  ASSERT_TRUE(Call({Path("new"), "--images", Path("photos/")}).ok());
  EXPECT_THAT(out_, HasSubstr("reconstruct  "));
  EXPECT_THAT(out_, HasSubstr("run: expected to take about "));
}

TEST_F(PlanCommandTest, OptionsAndPhotosCount) {
  const std::vector<std::string> words = {
      Path("new"), "--images", Path("photos")};
  const json some = Plan(words);
  std::vector<std::string> with = words;
  with.insert(with.end(), {"--preset", "fast"});
  EXPECT_LT(Plan(with)["total"]["seconds"], some["total"]["seconds"]);
  for (int i = 6; i < 20; ++i) {
    folder_.Write("photos/" + std::to_string(i) + ".jpg",
                  photos::MakeJpeg(128, 96, i));
  }
  const json more = Plan(words);
  for (const char* key : {"seconds", "memory_bytes", "disk_bytes"}) {
    EXPECT_GT(more["total"][key], some["total"][key]) << key;
  }
}

// Stage ingest alone needs no other program.
TEST_F(PlanCommandTest, WhatIsDoneIsUpToDateAndLeftAlone) {
  fs::create_directory(folder_ / "w");
  ASSERT_TRUE(pipeline::WriteWorkspaceInfo(
                  folder_ / "w", {Path("photos"), {{"general.seed", "4"}}})
                  .ok());
  PipelineOptions options;
  const pipeline::OptionTable table = MakeOptionTable(&options);
  const CancellationToken cancellation;
  std::ostringstream log;
  pipeline::Logger logger(log, /*terminal=*/false, "");
  pipeline::StageRunnerOptions run;
  run.workspace = folder_ / "w";
  run.images = folder_ / "photos";
  run.to = "ingest";
  ASSERT_TRUE(
      pipeline::StageRunner(
          MakeStages(options, table), std::move(run), cancellation, logger)
          .Run()
          .ok())
      << log.str();
  fs::remove(pipeline::FingerprintCachePath(folder_ / "w"));
  const auto files = [this] {
    return std::distance(fs::recursive_directory_iterator(folder_ / "w"), {});
  };
  const auto before = files();

  json plan = Plan({Path("w")});
  EXPECT_EQ(plan["stages"][0]["state"], "up_to_date");
  EXPECT_EQ(plan["stages"][0]["reason"], "");
  EXPECT_EQ(plan["stages"][0]["known"], true);
  EXPECT_EQ(plan["stages"][1]["state"], "needed");
  EXPECT_EQ(plan["stages"][1]["from_files"], true);
  EXPECT_EQ(plan["stages"][2]["from_files"], false);
  EXPECT_EQ(files(), before);
  ASSERT_TRUE(Call({Path("w")}).ok());
  EXPECT_THAT(out_, HasSubstr("up to date\n"));

  plan = Plan({Path("w"), "--ingest.holdout_every", "2"});
  EXPECT_EQ(plan["stages"][0]["state"], "needed");
  EXPECT_EQ(plan["stages"][0]["reason"],
            "option ingest.holdout_every changed 8 -> 2");
  folder_.Write("w/ingest/images.json", "{");
  plan = Plan({Path("w")});
  EXPECT_EQ(plan["stages"][1]["known"], false);
  EXPECT_EQ(plan["stages"][5]["known"], false);
}

TEST_F(PlanCommandTest, OfFilmsAndNoPhotosNothingIsKnown) {
  folder_.Write("films/a.mp4", "film");
  json plan = Plan({Path("new"), "--images", Path("films")});
  EXPECT_EQ(plan["stages"][0]["known"], false);
  EXPECT_THAT(plan["stages"][0]["advice"].get<std::string>(),
              HasSubstr("film"));
  EXPECT_EQ(plan["stages"][3]["memory_bytes"], 0);
  EXPECT_EQ(plan["total"]["seconds"], 0);
  ASSERT_TRUE(Call({Path("new"), "--images", Path("films")}).ok());
  EXPECT_THAT(out_, HasSubstr("not known"));
  EXPECT_THAT(out_, HasSubstr("\nrun: nothing is known of ingest, sfm"));
}

TEST_F(PlanCommandTest, BadInput) {
  const auto expect = [this](const std::vector<std::string>& arguments,
                             StatusCode code,
                             const std::string& part) {
    const Status status = Call(arguments);
    EXPECT_EQ(status.code(), code) << status.message();
    EXPECT_THAT(status.message(), HasSubstr(part));
  };
  expect({}, StatusCode::kInvalidArgument, "plan WORKSPACE");
  expect({Path("new")}, StatusCode::kBadInput, "no such workspace");
  expect({Path("new"), "--images", Path("none")},
         StatusCode::kBadInput,
         "no such folder of photos");
  fs::create_directory(folder_ / "w");
  expect({Path("w")},
         StatusCode::kInvalidArgument,
         "does not know its photos yet");
  expect({Path("w"), "--images", Path("photos"), "--sfm.no_such", "1"},
         StatusCode::kInvalidArgument,
         "unknown option");
  folder_.Write("w/ingest/photos/1.jpg", "x");
  expect({Path("w"), "--images", Path("w/ingest/photos")},
         StatusCode::kInvalidArgument,
         "lies in the folder of stage ingest");
  // What run refuses, plan does, too.
  folder_.Write("notes.txt", "x");
  expect({Path("new"), "--images", Path("notes.txt")},
         StatusCode::kBadInput,
         "not a folder and not a film");
  expect({Path("photos/w"), "--images", Path("photos")},
         StatusCode::kInvalidArgument,
         "inside the photo folder");
  folder_.Write("other/notes.txt", "x");
  expect({Path("other"), "--images", Path("photos")},
         StatusCode::kBadInput,
         "is not a workspace");
  folder_.Write("w/workspace.json", "{");
  expect({Path("w")}, StatusCode::kBadInput, "workspace.json");
}

}  // namespace
}  // namespace freegs::stages
