// SPDX-License-Identifier: BSD-3-Clause

#include "stages/bench/cell_runner.h"

#include <set>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/temporary_folder.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class CellRunnerTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_.Write("photos/a.jpg", "one");
    folder_.Write("program",
                  "#!/bin/sh\necho 'freegs_pipeline: dark'\nexit 4\n");
    fs::permissions(folder_ / "program", fs::perms::owner_all);
    context_.out = folder_ / "out";
    context_.program = folder_ / "program";
    context_.say = [](const std::string&) {};
    fs::create_directories(context_.out);
    context_.disturber.check = [](const std::string&) { return Status(); };
    context_.disturber.changes_poses = [](const std::string& text) {
      return text.starts_with("jitter");
    };
    context_.disturber.disturb =
        [this](const std::string&, const fs::path&, const fs::path&, uint64_t) {
          return disturbed_;
        };
    const StatusOr<Suite> suite = ParseSuite(
        "[suite]\nseeds = 1 2 3\n[scene a]\nimages = photos\n[grid g]\n"
        "disturb = none drop:1\n",
        folder_ / "s.ini");
    ASSERT_TRUE(suite.ok()) << suite.status().message();
    suite_ = *suite;
    SuiteChecks checks;
    checks.disturb = context_.disturber.check;
    const auto cells = MakeCells(suite_, checks);
    ASSERT_TRUE(cells.ok()) << cells.status().message();
    cells_ = *cells;
  }

  StatusOr<std::vector<CellResult>> Run(int jobs) {
    FREEGS_ASSIGN_OR_RETURN(const std::vector<ScenePhotos> photos,
                            FindAllPhotos(suite_, context_));
    CellRunnerOptions options;
    options.jobs = jobs;
    options.finished = [this](const std::vector<CellResult>& results) {
      ++finished_;
      EXPECT_EQ(results.size(), cells_.size());
      return Status();
    };
    return RunCells(suite_, cells_, photos, context_, options);
  }

  TemporaryFolder folder_;
  BenchContext context_;
  Status disturbed_ = BadInputError("nothing is left");
  Suite suite_;
  std::vector<SuiteCell> cells_;
  int finished_ = 0;
};

TEST_F(CellRunnerTest, FailuresAreResults) {
  for (const int jobs : {1, 3}) {
    finished_ = 0;
    const auto results = Run(jobs);
    ASSERT_TRUE(results.ok()) << results.status().message();
    EXPECT_EQ(finished_, 6);
    for (size_t i = 0; i < 3; ++i) {
      const CellResult& failed = (*results)[i];
      EXPECT_EQ(failed.status, CellStatus::kFailed);
      EXPECT_EQ(failed.exit_code, 4);
      EXPECT_EQ(failed.failed_stage, "ingest");
      EXPECT_EQ(failed.reason, "dark");
      EXPECT_TRUE(fs::exists(context_.out / failed.folder / "cell.json"));
      const CellResult& undisturbed = (*results)[i + 3];
      EXPECT_EQ(undisturbed.exit_code, 3);
      EXPECT_EQ(undisturbed.reason, "nothing is left");
    }
  }
}

TEST_F(CellRunnerTest, ACellNamesEachProgramOnce) {
  const auto run = [this](const std::string& script) {
    folder_.Write("program", "#!/bin/sh\n" + script);
    const auto results = Run(1);
    EXPECT_TRUE(results.ok()) << results.status().message();
    return results.ok() ? (*results)[0].programs : std::set<std::string>();
  };
  // What failed for a fault of the system is tried again.
  const auto first = run("exit 5\n");
  EXPECT_EQ(first.size(), 1u);
  const auto both = run("exit  5\n");
  EXPECT_EQ(both.size(), 2u);
  EXPECT_TRUE(both.contains(*first.begin()));
  EXPECT_EQ(run("exit 5\n"), both);
}

TEST_F(CellRunnerTest, AFaultOfTheSystemEndsTheBench) {
  disturbed_ = InternalError("the disk is full");
  const auto results = Run(2);
  EXPECT_THAT(results.status().message(), HasSubstr("the disk is full"));
}

}  // namespace
}  // namespace freegs::stages
