// SPDX-License-Identifier: BSD-3-Clause
// The options of earlier commands: which command uses them, shows them, and
// drops them.

#include "stages/command_line/remembered_options.h"

#include <filesystem>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/cancellation.h"
#include "stages/commands/run_command.h"
#include "stages/commands/status_command.h"
#include "tests/temporary_folder.h"

namespace freegs::stages {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::Pair;

class RememberedOptionsTest : public ::testing::Test {
 protected:
  RememberedOptionsTest() {
    // Stage ingest refuses it, after the options are remembered.
    WriteText(folder_ / "photos" / "1.jpg", "x");
  }

  Status Call(CommandFn command, std::vector<std::string> arguments) {
    std::ostringstream out;
    std::ostringstream err;
    CommandContext context{out, err, cancellation_, "freegs_pipeline"};
    const Status status = command(arguments, context);
    out_ = out.str();
    err_ = err.str();
    return status;
  }

  // Runs with IMAGES or without. The photos are no photos, so what comes of it
  // is kBadInput.
  void Run(bool with_images, const std::vector<std::string>& options) {
    std::vector<std::string> arguments;
    if (with_images) arguments.push_back((folder_ / "photos").string());
    arguments.push_back(Workspace());
    arguments.insert(arguments.end(), options.begin(), options.end());
    const Status status = Call(RunRunCommand, arguments);
    EXPECT_EQ(status.code(), StatusCode::kBadInput) << status.message();
  }

  std::string Workspace() const { return (folder_ / "w").string(); }

  std::map<std::string, std::string> Remembered() const {
    const auto info = pipeline::ReadWorkspaceInfo(Workspace());
    EXPECT_TRUE(info.ok()) << info.status().message();
    return info.ok() ? info->settings : std::map<std::string, std::string>();
  }

  TemporaryFolder folder_;
  CancellationToken cancellation_;
  std::string out_;
  std::string err_;
};

TEST_F(RememberedOptionsTest, RunOfPhotosBeginsAnewAndSaysSo) {
  Run(true, {"--seed", "4", "--sfm.camera", "single"});
  EXPECT_THAT(err_, Not(HasSubstr("options")));
  Run(true, {"--seed", "4"});
  EXPECT_THAT(err_,
              HasSubstr("do not hold any more: sfm.camera single (run "
                        "WORKSPACE, without IMAGES, keeps them)"));
  EXPECT_THAT(Remembered(), ElementsAre(Pair("general.seed", "4")));
}

TEST_F(RememberedOptionsTest, RunOfAWorkspaceGoesOnWithThem) {
  Run(true, {"--seed", "4", "--sfm.import", (folder_ / "w/poses").string()});
  Run(false, {"--sfm.camera", "single", "--seed", "5"});
  EXPECT_THAT(err_,
              HasSubstr("run: uses remembered options: sfm.import poses\n"));
  EXPECT_THAT(Remembered(),
              ElementsAre(Pair("general.seed", "5"),
                          Pair("sfm.camera", "single"),
                          Pair("sfm.import", "poses")));
}

TEST_F(RememberedOptionsTest, ProgramsAreFoundFromOtherFolders) {
  Run(true, {"--sfm.colmap", "tools/colmap"});
  const std::filesystem::path path = std::filesystem::current_path() / "tools";
  EXPECT_THAT(Remembered(),
              ElementsAre(Pair("sfm.colmap", (path / "colmap").string())));
  Run(true, {"--sfm.colmap", "colmap"});
  EXPECT_THAT(Remembered(), ElementsAre(Pair("sfm.colmap", "colmap")));
}

TEST_F(RememberedOptionsTest, ForgetDropsOnlyWhatIsNamed) {
  const std::vector<std::string> options = {
      "--seed", "4", "--sfm.camera", "single", "--verbose"};
  Run(true, options);
  Run(false, {"--forget", "sfm.camera"});
  EXPECT_THAT(err_,
              HasSubstr("uses remembered options: general.seed 4, "
                        "general.verbose true\n"));
  Run(true, options);
  // Who forgets one means to keep the others, with or without IMAGES.
  Run(true, {"--forget", "seed", "--forget=general.verbose"});
  EXPECT_THAT(Remembered(), ElementsAre(Pair("sfm.camera", "single")));
  Run(false, {"--forget", "all", "--seed", "6"});
  EXPECT_THAT(err_, Not(HasSubstr("remembered options")));
  EXPECT_THAT(Remembered(), ElementsAre(Pair("general.seed", "6")));
}

TEST_F(RememberedOptionsTest, ForgetWhatIsNotRemembered) {
  Run(true, {"--seed", "4", "--sfm.camera", "single"});
  const Status status =
      Call(RunRunCommand, {Workspace(), "--forget", "sfm.matcher"});
  EXPECT_EQ(status.code(), StatusCode::kInvalidArgument);
  EXPECT_THAT(status.message(),
              HasSubstr("remembers only general.seed 4, sfm.camera single"));
  EXPECT_EQ(Remembered().size(), 2u);
  Run(false, {"--forget", "all"});
  EXPECT_THAT(Call(RunRunCommand, {Workspace(), "--forget", "seed"}).message(),
              HasSubstr("no options"));
}

TEST_F(RememberedOptionsTest, StageUsesThemAndSaysSo) {
  Run(true, {"--seed", "4"});
  const Status status =
      Call(RunStageCommand, {"ingest", Workspace(), "--threads", "1"});
  EXPECT_EQ(status.code(), StatusCode::kBadInput) << status.message();
  EXPECT_THAT(err_,
              HasSubstr("stage: uses remembered options: general.seed 4\n"));
  EXPECT_EQ(Remembered().size(), 2u);
  EXPECT_EQ(
      Call(RunStageCommand, {"ingest", Workspace(), "--forget", "sfm.camera"})
          .code(),
      StatusCode::kInvalidArgument);
  EXPECT_EQ(
      Call(RunStageCommand, {"ingest", Workspace(), "--forget", "seed"}).code(),
      StatusCode::kBadInput);
  EXPECT_THAT(Remembered(), ElementsAre(Pair("general.threads", "1")));
}

TEST_F(RememberedOptionsTest, StatusShowsThem) {
  Run(true, {"--seed", "4", "--reconstruct.iterations", "2500"});
  WriteText(folder_ / "w" / "config.ini",
            "[general]\nseed = 3\n[sfm]\ncamera = single\n");
  ASSERT_TRUE(Call(RunStatusCommand, {Workspace()}).ok());
  EXPECT_THAT(out_, HasSubstr("* general.seed 4  (default 0)\n"));
  EXPECT_THAT(out_,
              HasSubstr("  reconstruct.iterations 2500  (the default)\n"));
  EXPECT_THAT(out_, HasSubstr("config.ini"));
  EXPECT_THAT(out_, HasSubstr("* sfm.camera single  (default auto)\n"));

  ASSERT_TRUE(Call(RunStatusCommand, {Workspace(), "--json"}).ok());
  const auto json = nlohmann::json::parse(out_)["options"];
  ASSERT_EQ(json.size(), 3u);
  EXPECT_EQ(json[0],
            nlohmann::json({{"name", "general.seed"},
                            {"value", "4"},
                            {"default", "0"},
                            {"changed", true},
                            {"source", "workspace.json"}}));
  EXPECT_EQ(json[1]["changed"], false);
  EXPECT_EQ(json[2]["source"], "config.ini");
}

TEST_F(RememberedOptionsTest, AnOptionOfAnotherVersionCanBeForgotten) {
  WriteText(folder_ / "w" / "workspace.json",
            R"({"images": ")" + (folder_ / "photos").string() +
                R"(", "settings": {"sfm.gone": "1"}})");
  ASSERT_TRUE(Call(RunStatusCommand, {Workspace()}).ok());
  EXPECT_THAT(out_, HasSubstr("sfm.gone 1  (this program has no such option)"));
  Run(false, {"--forget", "sfm.gone"});
  EXPECT_THAT(Remembered(), IsEmpty());
}

}  // namespace
}  // namespace freegs::stages
