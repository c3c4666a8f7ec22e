// SPDX-License-Identifier: BSD-3-Clause

#include "pipeline/progress_file.h"

#include <filesystem>

#include <gtest/gtest.h>

#include "pipeline/workspace.h"
#include "tests/temporary_folder.h"

namespace freegs::pipeline {
namespace {

TEST(ProgressFile, TellsWhatIsGoingOnAndDisappears) {
  const TemporaryFolder workspace;
  double now = 100;
  {
    ProgressFile file(workspace.path(), "reconstruct", [&now] { return now; });
    auto progress = ReadProgressFile(workspace.path());
    ASSERT_TRUE(progress.ok()) << progress.status().message();
    EXPECT_EQ(progress->stage, "reconstruct");
    EXPECT_EQ(progress->step, "");
    EXPECT_FALSE(progress->seconds_left);

    now += 0.5;  // Too early.
    file.Report({"training", 10, 100, ""});
    EXPECT_EQ(ReadProgressFile(workspace.path())->step, "");
    now += 2;
    file.Report({"training", 30, 100, ""});
    progress = ReadProgressFile(workspace.path());
    ASSERT_TRUE(progress.ok()) << progress.status().message();
    EXPECT_EQ(progress->step, "training");
    EXPECT_EQ(progress->done, 30);
    EXPECT_EQ(progress->total, 100);
    EXPECT_NEAR(progress->seconds_left.value_or(0), 7, 1e-6);
    workspace.Write("preview.jpg", "a picture");
  }
  EXPECT_TRUE(std::filesystem::is_empty(workspace.path()));
  EXPECT_FALSE(ReadProgressFile(workspace.path()).ok());
}

TEST(ProgressFile, RefusesWhatSomebodyElseWrote) {
  const TemporaryFolder workspace;
  for (const char* text : {"",
                           "[]",
                           R"({"stage": "sfm"})",
                           R"({"stage": 1, "step": "", "done": 0, "total": 0,
            "seconds_left": null})"}) {
    workspace.Write("progress.json", text);
    EXPECT_FALSE(ReadProgressFile(workspace.path()).ok()) << text;
  }
}

}  // namespace
}  // namespace freegs::pipeline
