// SPDX-License-Identifier: BSD-3-Clause

#include "stages/registry/stage_registry.h"

#include <filesystem>
#include <sstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/cancellation.h"
#include "pipeline/logger.h"
#include "pipeline/stage_runner.h"
#include "stages/registry/pipeline_options.h"
#include "tests/temporary_folder.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;

Status RunFrom(const fs::path& workspace, const std::string& from) {
  PipelineOptions options;
  const pipeline::OptionTable table = MakeOptionTable(&options);
  const CancellationToken cancellation;
  std::ostringstream console;
  pipeline::Logger logger(console, /*terminal=*/false, "");
  pipeline::StageRunnerOptions run;
  run.workspace = workspace;
  run.from = from;
  run.num_threads = 1;
  pipeline::StageRunner runner(
      MakeStages(options, table), run, cancellation, logger);
  return runner.Run();
}

// A scene that somebody else made may have no folder of stage sfm.
TEST(StageRegistryTest, FromBootstrapNeedsNoFolderOfSfm) {
  const TemporaryFolder folder;
  for (const char* stage : {"ingest", "undistort", "reconstruct"}) {
    EXPECT_THAT(RunFrom(folder.path(), "bootstrap").message(),
                HasSubstr(std::string("stage ") + stage + " has no result"));
    fs::create_directory(folder / stage);
  }
  // The folders are empty, so the first stage fails.
  const Status status = RunFrom(folder.path(), "bootstrap");
  ASSERT_FALSE(status.ok());
  EXPECT_THAT(status.message(), Not(HasSubstr("has no result")));
  EXPECT_THAT(status.message(), HasSubstr("bootstrap"));
}

}  // namespace
}  // namespace freegs::stages
