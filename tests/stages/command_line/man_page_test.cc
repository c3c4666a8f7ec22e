// SPDX-License-Identifier: BSD-3-Clause
// Text for roff, the man page and the page of all options, of a small command.

#include "stages/command_line/man_page.h"

#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "stages/command_line/options_reference.h"
#include "stages/command_line/roff.h"

namespace freegs::stages {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

struct PenRequest {
  int count = 3;
  double width = 0.5;
  std::string ink = "black";
  std::string file;
  std::string out;
};

pipeline::OptionTable PenTable(PenRequest* request) {
  pipeline::OptionTable table;
  table.AddSection("pen", "What a_b draws with.");
  table.Add("pen.count", &request->count, {.help = "How many.", .min = 1});
  table.Add("pen.width", &request->width, {.help = "In a|b, at *most*."});
  table.Add("pen.ink",
            &request->ink,
            {.help = "Colour.", .choices = {"black", "red"}});
  table.Add("pen.file", &request->file, {.help = "File.", .is_path = true});
  table.AddAlias("count", "pen.count");
  table.NotePreset("fast", "pen.count", "2");
  return table;
}

CommandWords DescribePen(PenRequest* request) {
  CommandWords words("draw", "Draws view-dependent lines.", PenTable(request));
  words.AddArgument(WorkspaceArgument());
  words.AddOption(
      "out", &request->out, {.help = "Where.", .value_name = "DIR"});
  words.AddLetter('o', "out");
  words.AddNote("'Quoted' notes are not requests.");
  return words;
}

TEST(RoffTest, WhatMeansSomethingToRoffIsEscaped) {
  EXPECT_EQ(RoffEscaped("a\\b-c", true), "a\\eb\\-c");
  EXPECT_EQ(RoffEscaped("a-c", false), "a-c");
  EXPECT_EQ(RoffEscaped("it's `~^`", false), "it\\(aqs \\(ga\\(ti\\(ha\\(ga");
  EXPECT_EQ(RoffEscaped("\xc3\xa4 \xe2\x80\x93", false), "\\[u00E4] \\[u2013]");
  EXPECT_EQ(RoffEscaped("\xff\xc3", false), "??");
}

TEST(RoffTest, HyphensOfNamesAreThoseOfTheKeyboard) {
  EXPECT_EQ(RoffText("view-dependent (well-known), --out-dir a-1.png"),
            "view-dependent (well-known), \\-\\-out\\-dir a\\-1.png\n");
}

TEST(RoffTest, NoLineIsARequest) {
  EXPECT_EQ(RoffText(".ply and"), "\\&.ply and\n");
  EXPECT_EQ(RoffText("'a"), "\\(aqa\n");
  EXPECT_EQ(RoffUsage("..."), "\\fB...\\fR\n");
  EXPECT_EQ(RoffExample("a\n.b\n"), "a\n\\&.b\n");
}

TEST(RoffTest, UsageTellsWordsFromPlaceholders) {
  EXPECT_EQ(
      RoffUsage("--click VIEW X0 [a|b]"),
      "\\fB\\-\\-click\\fR \\fIVIEW\\fR \\fIX0\\fR [\\fBa\\fR|\\fBb\\fR]\n");
}

TEST(ManPageTest, HoldsCommandsAndTheOptionsOfTheStagesOnce) {
  PenRequest request;
  const std::string page =
      ManPage({KeepWords<PenRequest>(DescribePen)}, PenTable(&request));
  EXPECT_THAT(
      page,
      AllOf(HasSubstr(".SY freegs_pipeline\n\\fBdraw\\fR \\fIWORKSPACE\\fR"),
            HasSubstr(".SS \"draw WORKSPACE [OPTIONS]\"\n"
                      "Draws view-dependent lines.\n"),
            HasSubstr(".TP\n\\fB\\-o\\fR, \\fB\\-\\-out\\fR \\fIDIR\\fR\n"
                      "Where.\n"),
            HasSubstr("It also takes all OPTIONS OF THE STAGES"),
            HasSubstr(".SS \"[pen]\"\n"),
            HasSubstr("\\fB\\-\\-pen.count\\fR \\fIN\\fR, "
                      "\\fB\\-\\-count\\fR\n"
                      "How many. [default 3; at least 1; preset fast: 2]\n"),
            HasSubstr("\n\\(aqQuoted\\(aq notes")));
  for (const char* section : {"NAME",
                              "SYNOPSIS",
                              "DESCRIPTION",
                              "COMMANDS",
                              "OPTIONS OF THE STAGES",
                              "FILES",
                              "ENVIRONMENT",
                              "EXIT STATUS",
                              "EXAMPLES",
                              "SEE ALSO"}) {
    EXPECT_THAT(page, HasSubstr("\n.SH " + std::string(section) + "\n"));
  }
  EXPECT_EQ(page.find("pen.width"), page.rfind("pen.width"));
}

TEST(ManPageTest, NamesTheOptionsOfACommandThatTakesSome) {
  PenRequest request;
  CommandWords words = DescribePen(&request);
  words.table().LimitCommandLine({"pen.ink"});
  const std::string page = ManPage({words}, PenTable(&request));
  EXPECT_THAT(page, HasSubstr("it takes \\-\\-pen.ink.\n"));
  EXPECT_THAT(page, Not(HasSubstr("It also takes all")));
}

TEST(OptionsReferenceTest, TablesBySection) {
  PenRequest request;
  EXPECT_THAT(
      OptionsReference(PenTable(&request)),
      HasSubstr(
          "\n## pen\n\nWhat a\\_b draws with.\n\n"
          "| key | values | default | presets | what it does |\n"
          "|---|---|---|---|---|\n"
          "| `count`, `--count` | a whole number, at least 1 | `3` | fast: `2` "
          "| How many. |\n"
          "| `width` | a number | `0.5` |  | In a\\|b, at \\*most\\*. |\n"
          "| `ink` | `black`, `red` | `black` |  | Colour. |\n"
          "| `file` | a path | empty |  | File. |\n"));
}

}  // namespace
}  // namespace freegs::stages
