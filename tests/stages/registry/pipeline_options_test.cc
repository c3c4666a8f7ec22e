// SPDX-License-Identifier: BSD-3-Clause
// The pipeline's own option table: order of precedence, presets, stages.

#include "stages/registry/pipeline_options.h"

#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pipeline/workspace.h"
#include "stages/registry/presets.h"
#include "stages/registry/stage_registry.h"
#include "tests/temporary_folder.h"

namespace freegs::stages {
namespace {

using pipeline::OptionSetting;
using pipeline::OptionTable;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(PipelineOptionsTest, TableIsConsistent) {
  PipelineOptions options;
  const OptionTable table = MakeOptionTable(&options);
  EXPECT_TRUE(table.Check().ok()) << table.Check().message();
  for (const OptionTable::Option& option : table.options()) {
    EXPECT_FALSE(option.section().empty()) << option.name;
    EXPECT_FALSE(option.spec.help.empty()) << option.name;
  }
}

TEST(PipelineOptionsTest, CommandLineWinsOverConfigOverDefault) {
  const TemporaryFolder folder;
  WriteText(pipeline::ConfigPath(folder.path()),
            "[general]\nseed = 5\nthreads = 3\n");
  PipelineOptions options;
  OptionTable table = MakeOptionTable(&options);
  const auto line = table.ParseCommandLine({"--seed", "6"});
  ASSERT_TRUE(line.ok());
  ASSERT_TRUE(ApplySettings(folder.path(), line->settings, table).ok());
  EXPECT_EQ(options.general.seed, 6);
  EXPECT_EQ(options.general.threads, 3);
  EXPECT_EQ(options.general.checkpoint_interval, 60);
}

TEST(PipelineOptionsTest, MistakeInConfigNamesTheFile) {
  const TemporaryFolder folder;
  WriteText(pipeline::ConfigPath(folder.path()), "[general]\nsede = 5\n");
  PipelineOptions options;
  OptionTable table = MakeOptionTable(&options);
  const Status status = ApplySettings(folder.path(), {}, table);
  EXPECT_EQ(status.code(), StatusCode::kInvalidArgument);
  EXPECT_THAT(status.message(),
              AllOf(HasSubstr("config.ini"), HasSubstr("general.seed")));
}

TEST(PipelineOptionsTest, EveryPresetSetsKnownOptionsToAllowedValues) {
  for (const std::string& name : PresetNames()) {
    const auto settings = PresetSettings(name);
    ASSERT_TRUE(settings.ok());
    PipelineOptions options;
    OptionTable table = MakeOptionTable(&options);
    const Status status = table.Apply(*settings);
    EXPECT_TRUE(status.ok()) << status.message();
    // By way of the command line and of config.ini.
    const TemporaryFolder folder;
    const auto line = table.ParseCommandLine({"--preset", name});
    ASSERT_TRUE(line.ok());
    EXPECT_TRUE(ApplySettings(folder.path(), line->settings, table).ok());
    EXPECT_EQ(options.general.preset, name);
  }
  EXPECT_FALSE(PresetSettings("sloppy").ok());
}

TEST(PipelineOptionsTest, RememberedSettingsSurviveAMove) {
  PipelineOptions options;
  const OptionTable table = MakeOptionTable(&options);
  pipeline::WorkspaceInfo info;
  info.settings = {{"general.seed", "4"},
                   {"sfm.import", "imported/model"},
                   {"general.no_longer_there", "1"}};
  const std::vector<OptionSetting> settings =
      RememberedSettings("/w", info, table);
  ASSERT_EQ(settings.size(), 2u);
  EXPECT_EQ(settings[0].value, "4");
  EXPECT_EQ(settings[1].value, "/w/imported/model");
}

TEST(StageRegistryTest, SixStagesInOrder) {
  PipelineOptions options;
  options.general.seed = 8;
  const OptionTable table = MakeOptionTable(&options);
  std::vector<std::string> names;
  std::vector<std::string> seeded;
  for (const pipeline::RunnerStage& stage : MakeStages(options, table)) {
    names.emplace_back(stage.stage->name());
    if (stage.options.contains("general.seed")) {
      EXPECT_EQ(stage.options.at("general.seed"), "8");
      seeded.push_back(names.back());
    }
    for (const auto& [name, value] : stage.options) {
      EXPECT_TRUE(name == "general.seed" ||
                  name.starts_with(names.back() + "."))
          << name;
      EXPECT_FALSE(stage.other_options.contains(name)) << name;
    }
  }
  EXPECT_THAT(
      names,
      ElementsAre(
          "ingest", "sfm", "undistort", "reconstruct", "bootstrap", "export"));
  EXPECT_THAT(seeded, ElementsAre("sfm", "reconstruct", "bootstrap"));
}

TEST(PipelineOptionsTest, QuestionsUseWhatTheWorkspaceRemembers) {
  const TemporaryFolder folder;
  WriteText(folder / "config.ini", "[general]\npreset = auto\n");
  const auto apply = [&](PipelineOptions* options) {
    pipeline::OptionTable table = MakeOptionTable(options);
    return ApplyQuerySettings(folder.path(), {}, table);
  };
  PipelineOptions options;
  EXPECT_EQ(apply(&options).code(), StatusCode::kInvalidArgument);
  pipeline::WorkspaceInfo info;
  info.settings = {{"general.preset", "balanced"},
                   {"query.background", "true"},
                   {"general.threads", "3"}};
  ASSERT_TRUE(pipeline::WriteWorkspaceInfo(folder.path(), info).ok());
  const Status status = apply(&options);
  ASSERT_TRUE(status.ok()) << status.message();
  EXPECT_TRUE(options.query.background);
  EXPECT_EQ(options.general.threads, 0);
}

}  // namespace
}  // namespace freegs::stages
