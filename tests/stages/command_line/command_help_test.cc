// SPDX-License-Identifier: BSD-3-Clause
// The help of a command, laid out for a terminal.

#include "stages/command_line/command_help.h"

#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace freegs::stages {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

struct HelpRequest {
  int count = 3;
  bool json = false;
  bool deep = true;
  std::string mode = "auto";
  std::vector<std::vector<std::string>> drop;
};

CommandWords DescribeHelp(HelpRequest* request) {
  pipeline::OptionTable table;
  table.AddSection("a", "About a.");
  table.Add("a.count", &request->count, {.help = "How many.", .min = 1});
  table.Add("a.deep", &request->deep, {.help = "Deep."});
  table.NotePreset("fast", "a.count", "2");
  table.NotePreset("good", "a.count", "5");
  table.AddAlias("count", "a.count");
  CommandWords words("draw", "Draws.", std::move(table));
  words.AddArgument(WorkspaceArgument());
  words.AddOption("json", &request->json, {.help = "Print JSON."});
  words.AddOption(
      "mode", &request->mode, {.help = "How.", .choices = {"auto", "ink"}});
  words.AddLetter('m', "mode");
  words.AddListOption({.name = "drop",
                       .value_names = {"KEY"},
                       .help = "Drop.",
                       .target = &request->drop,
                       .repeats = true});
  words.AddNote("A note.");
  return words;
}

TEST(CommandHelpTest, ShowsAllThatTheWordsTell) {
  EXPECT_EQ(CommandHelp(KeepWords<HelpRequest>(DescribeHelp)),
            R"(freegs_pipeline draw WORKSPACE [OPTIONS]

Draws.

Arguments:
  WORKSPACE
      The folder of the scene.

Options:
  --drop KEY
      Drop. It may be given several times.
  --json
      Print JSON.
  -m, --mode auto|ink
      How. [default auto]

[a] About a.
  --a.count N, --count
      How many. [default 3; at least 1; preset fast: 2, good: 5]
  --a.deep true|false
      Deep. [default true]

A note.
)");
}

TEST(CommandHelpTest, MayReferToTheOptionsOfAnotherCommand) {
  HelpRequest request;
  CommandWords words = DescribeHelp(&request);
  words.ReferToOptionsOf("run");
  const std::string help = CommandHelp(words);
  EXPECT_THAT(help, HasSubstr("--json"));
  EXPECT_THAT(help, Not(HasSubstr("--a.count")));
  EXPECT_THAT(help, HasSubstr("freegs_pipeline run --help"));
}

TEST(CommandHelpTest, ProgramHelpListsCommands) {
  EXPECT_THAT(ProgramHelp({KeepWords<HelpRequest>(DescribeHelp)}),
              HasSubstr("\n  freegs_pipeline draw WORKSPACE [OPTIONS]\n"
                        "      Draws.\n"));
}

TEST(WrapTextTest, LinesHaveAtMost80Columns) {
  const std::string word(39, 'a');
  EXPECT_EQ(WrapText(word + " " + word, "- ", 2),
            "- " + word + "\n  " + word + "\n");
  EXPECT_EQ(WrapText(word + " " + word, "", 2), word + " " + word + "\n");
  const std::string long_word(100, 'b');
  EXPECT_EQ(WrapText("a " + long_word, "", 1), "a\n " + long_word + "\n");
}

}  // namespace
}  // namespace freegs::stages
