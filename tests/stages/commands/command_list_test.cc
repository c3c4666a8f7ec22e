// SPDX-License-Identifier: BSD-3-Clause
// What holds for all commands: the help names every word that is accepted. Of
// the pages tests/docs/pages_test.cc asks the same.

#include "stages/commands/command_list.h"

#include <sstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "stages/command_line/command_help.h"
#include "stages/command_line/version_text.h"

namespace freegs::stages {
namespace {

using pipeline::OptionTable;
using ::testing::HasSubstr;

// A value that the option takes.
std::string SomeValue(const OptionTable::Option& option) {
  if (!option.default_value.empty()) return option.default_value;
  return option.spec.choices.empty() ? "1" : option.spec.choices.front();
}

TEST(CommandListTest, DeclarationsAreConsistent) {
  for (const Command& command : Commands()) {
    const CommandWords words = command.words();
    EXPECT_EQ(words.name(), command.name);
    EXPECT_TRUE(words.table().Check().ok()) << words.table().Check().message();
    EXPECT_FALSE(words.summary().empty());
    for (const Argument& argument : words.arguments()) {
      EXPECT_FALSE(argument.help.empty()) << command.name;
    }
    for (const OptionTable::Option& option : words.table().options()) {
      EXPECT_FALSE(option.spec.help.empty()) << option.name;
    }
    EXPECT_TRUE(FindCommand(words.name()).ok());
  }
  EXPECT_THAT(FindCommand("qeury").status().message(),
              HasSubstr("did you mean query?"));
}

TEST(CommandListTest, HelpNamesEveryOptionThatIsAccepted) {
  const std::string of_run = CommandHelp(FindCommand("run")->words());
  for (const Command& command : Commands()) {
    const CommandWords words = command.words();
    const std::string help = CommandHelp(words);
    for (const Argument& argument : words.arguments()) {
      EXPECT_THAT(help, HasSubstr("\n  " + argument.name + "\n"));
    }
    for (const ListOption& option : words.list_options()) {
      EXPECT_THAT(help, HasSubstr("\n  " + words.OptionUsage(option.name)));
    }
    for (const OptionTable::Option& option : words.table().options()) {
      std::vector<std::string> arguments = {"--" + option.name};
      if (!option.is_switch()) arguments.push_back(SomeValue(option));
      const bool accepted = words.table().ParseCommandLine(arguments).ok();
      EXPECT_EQ(accepted, option.on_command_line) << option.name;
      if (!accepted) continue;
      const bool referred =
          !option.section().empty() && words.refers_to() == "run";
      EXPECT_THAT(referred ? of_run : help, HasSubstr("--" + option.name));
    }
    if (!words.refers_to().empty()) {
      EXPECT_THAT(help, HasSubstr(words.refers_to() + " --help"));
    }
    for (const auto& [alias, name] : words.table().aliases()) {
      if (!words.refers_to().empty()) continue;
      const bool accepted = words.table().Find(name)->on_command_line;
      EXPECT_EQ(help.find(", --" + alias) != std::string::npos, accepted)
          << alias;
    }
  }
}

TEST(CommandListTest, HelpFitsATerminal) {
  for (const Command& command : Commands()) {
    std::istringstream lines(CommandHelp(command.words()));
    for (std::string line; std::getline(lines, line);) {
      EXPECT_LE(line.size(), 80u) << line;
      EXPECT_FALSE(line.ends_with(' ')) << line;
    }
  }
}

TEST(CommandListTest, HelpOfRunShowsWhatPresetsSet) {
  EXPECT_THAT(CommandHelp(FindCommand("run")->words()),
              HasSubstr("preset fast: 640"));
}

TEST(VersionTextTest, NamesCommitAndLicence) {
  const std::string text = VersionText("0123abc");
  EXPECT_THAT(text, HasSubstr("commit 0123abc\n"));
  EXPECT_THAT(text, HasSubstr("BSD-3-Clause"));
  EXPECT_THAT(text, HasSubstr(InstructionSets()));
}

}  // namespace
}  // namespace freegs::stages
