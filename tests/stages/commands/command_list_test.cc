// SPDX-License-Identifier: BSD-3-Clause
// What holds for all commands: the help names every word that is accepted, and
// the pages name no word that is not.

#include "stages/commands/command_list.h"

#include <filesystem>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "stages/command_line/command_help.h"
#include "stages/command_line/completion_values.h"
#include "stages/command_line/version_text.h"
#include "tests/temporary_folder.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;
using pipeline::OptionTable;
using ::testing::HasSubstr;

std::set<std::string> OptionWords(const CommandWords& words) {
  std::set<std::string> names;
  for (const CompletedOption& option : CompletedOptions(words)) {
    names.insert(option.word);
  }
  return names;
}

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

// The text of the pages, with lines that end in a backslash joined.
std::string Pages() {
  const fs::path root = FREEGS_SOURCE_DIR;
  std::string text = ReadText(root / "README.md") +
                     ReadText(root / "workspace_template" / "README.md");
  for (const auto& entry : fs::directory_iterator(root / "docs")) {
    if (entry.path().extension() == ".md") text += ReadText(entry.path());
  }
  return std::regex_replace(text, std::regex("\\\\\n"), " ");
}

TEST(CommandListTest, PagesNameOnlyWordsThatExist) {
  const std::set<std::string> of_run = OptionWords(FindCommand("run")->words());
  const std::regex command_line("freegs_pipeline ([a-z]+)([^`\n|;&]*)");
  const std::regex option("--[a-z][a-z_.-]*[a-z]");
  const std::regex with_section("--[a-z]+\\.[a-z_]+");
  const std::string pages = Pages();
  int seen = 0;
  const auto end = std::sregex_iterator();
  for (auto at = std::sregex_iterator(pages.begin(), pages.end(), command_line);
       at != end;
       ++at) {
    const auto command = FindCommand((*at)[1]);
    if (!command.ok()) continue;  // A word of a sentence.
    const std::set<std::string> known = OptionWords(command->words());
    const std::string rest = (*at)[2];
    for (auto word = std::sregex_iterator(rest.begin(), rest.end(), option);
         word != end;
         ++word) {
      EXPECT_TRUE(known.contains(word->str())) << at->str();
      ++seen;
    }
  }
  EXPECT_GT(seen, 10);
  for (auto at = std::sregex_iterator(pages.begin(), pages.end(), with_section);
       at != end;
       ++at) {
    EXPECT_TRUE(of_run.contains(at->str())) << at->str();
  }
}

TEST(VersionTextTest, NamesCommitAndLicence) {
  const std::string text = VersionText("0123abc");
  EXPECT_THAT(text, HasSubstr("commit 0123abc\n"));
  EXPECT_THAT(text, HasSubstr("BSD-3-Clause"));
  EXPECT_THAT(text, HasSubstr(InstructionSets()));
}

}  // namespace
}  // namespace freegs::stages
