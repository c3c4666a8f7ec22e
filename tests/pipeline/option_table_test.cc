// SPDX-License-Identifier: BSD-3-Clause
// The option table: parsing, precedence, and a clear message for every error.

#include "pipeline/option_table.h"

#include <filesystem>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/temporary_folder.h"

namespace freegs::pipeline {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

struct Values {
  bool enabled = true;
  int count = 3;
  int even = 2;
  int64_t seed = 1;
  double fraction = 0.25;
  std::string mode = "fast";
  std::string import;
  std::string colmap = "colmap";
  std::string from = "ingest";
  bool json = false;
};

class OptionTableTest : public ::testing::Test {
 protected:
  OptionTableTest() {
    table_.AddSection("sfm", "Cameras from photographs.");
    table_.Add("sfm.enabled", &values_.enabled, {.help = "Do it."});
    table_.Add("sfm.count",
               &values_.count,
               {.help = "How many.", .min = 1, .max = 10});
    table_.Add("general.seed", &values_.seed, {.help = "Seed.", .min = 0});
    table_.Add("sfm.fraction",
               &values_.fraction,
               {.help = "A share.", .min = 0, .max = 1});
    table_.Add(
        "sfm.mode",
        &values_.mode,
        {.help = "How.", .choices = {"fast", "slow"}, .affects_result = false});
    table_.Add(
        "sfm.even",
        &values_.even,
        {.help = "Even.",
         .min = 0,
         .accepts =
             [](const std::string& text) { return std::stoi(text) % 2 == 0; },
         .allowed = "even numbers"});
    table_.Add("sfm.import", &values_.import, {.help = "A.", .is_path = true});
    table_.Add("sfm.colmap",
               &values_.colmap,
               {.help = "A program.", .is_program = true});
    table_.Add("from", &values_.from, {.help = "First."});
    table_.Add("json", &values_.json, {.help = "As JSON."});
    table_.AddAlias("seed", "general.seed");
  }

  // Parses and applies; returns the positional words joined by '|'.
  StatusOr<std::string> Line(const std::vector<std::string>& arguments) {
    FREEGS_ASSIGN_OR_RETURN(const OptionTable::CommandLine line,
                            table_.ParseCommandLine(arguments));
    FREEGS_RETURN_IF_ERROR(table_.Apply(line.settings));
    std::string words;
    for (const std::string& word : line.positional) {
      words += (words.empty() ? "" : "|") + word;
    }
    return words;
  }

  Status Config(const std::string& text) {
    FREEGS_ASSIGN_OR_RETURN(const std::vector<OptionSetting> settings,
                            table_.ParseConfig(text, "/w", "/w/config.ini"));
    return table_.Apply(settings);
  }

  std::string LineError(const std::vector<std::string>& arguments) {
    const StatusOr<std::string> result = Line(arguments);
    EXPECT_EQ(result.status().code(), StatusCode::kInvalidArgument);
    return result.status().message();
  }

  std::string ConfigError(const std::string& text) {
    const Status status = Config(text);
    EXPECT_EQ(status.code(), StatusCode::kInvalidArgument);
    return status.message();
  }

  Values values_;
  OptionTable table_;
};

TEST_F(OptionTableTest, CommandLineFormsAndPositionalWords) {
  const StatusOr<std::string> words = Line({"a b",
                                            "--sfm.count",
                                            "7",
                                            "--sfm.fraction=0.5",
                                            "ws",
                                            "--json",
                                            "--seed",
                                            "42",
                                            "--sfm.enabled",
                                            "no"});
  ASSERT_TRUE(words.ok()) << words.status().message();
  EXPECT_EQ(*words, "a b|ws");
  EXPECT_EQ(values_.count, 7);
  EXPECT_EQ(values_.fraction, 0.5);
  EXPECT_EQ(values_.seed, 42);
  EXPECT_FALSE(values_.enabled);
  EXPECT_TRUE(values_.json);
}

TEST_F(OptionTableTest, LastOnCommandLineWins) {
  ASSERT_TRUE(Line({"--sfm.count", "2", "--sfm.count", "5"}).ok());
  EXPECT_EQ(values_.count, 5);
}

TEST_F(OptionTableTest, OptionsOfACommandAreGivenOnce) {
  EXPECT_EQ(LineError({"--from", "sfm", "--seed", "1", "--from=export"}),
            "--from is given twice");
  EXPECT_EQ(LineError({"--json", "--json"}), "--json is given twice");
  // This is an option of a stage, by another name.
  EXPECT_TRUE(Line({"--seed", "2", "--seed", "5"}).ok());
}

TEST_F(OptionTableTest, WordsAfterTwoDashesArePositional) {
  const StatusOr<std::string> words = Line({"--", "--sfm.count"});
  ASSERT_TRUE(words.ok());
  EXPECT_EQ(*words, "--sfm.count");
}

TEST_F(OptionTableTest, CommandLineErrorsNameOptionAndRange) {
  EXPECT_THAT(LineError({"--sfm.count", "11"}), HasSubstr("sfm.count"));
  EXPECT_THAT(LineError({"--sfm.count", "11"}), HasSubstr("1 .. 10"));
  EXPECT_THAT(LineError({"--sfm.count", "-1"}), HasSubstr("out of range"));
  EXPECT_THAT(LineError({"--sfm.count", "2.5"}),
              HasSubstr("not a whole number"));
  EXPECT_THAT(LineError({"--sfm.count", "99999999999"}),
              HasSubstr("does not fit"));
  EXPECT_THAT(LineError({"--sfm.count", ""}), HasSubstr("whole number"));
  EXPECT_THAT(LineError({"--seed", "-5"}), HasSubstr("at least 0"));
  EXPECT_THAT(LineError({"--sfm.fraction", "nan"}), HasSubstr("not a finite"));
  EXPECT_THAT(LineError({"--sfm.fraction", "inf"}), HasSubstr("not a finite"));
  EXPECT_THAT(LineError({"--sfm.fraction", "0.5x"}), HasSubstr("not a number"));
  EXPECT_THAT(LineError({"--sfm.mode", "medium"}), HasSubstr("fast, slow"));
  EXPECT_THAT(LineError({"--sfm.enabled", "maybe"}),
              HasSubstr("true or false"));
  EXPECT_THAT(LineError({"--sfm.even", "3"}),
              HasSubstr("'3' is not allowed; allowed: even numbers"));
}

TEST_F(OptionTableTest, AnOptionOfAStageMayBeEmptiedInBothForms) {
  for (const std::vector<std::string>& form :
       {std::vector<std::string>{"--sfm.import="}, {"--sfm.import", ""}}) {
    ASSERT_TRUE(Line({"--sfm.import", "/a"}).ok());
    const StatusOr<std::string> words = Line(form);
    ASSERT_TRUE(words.ok()) << words.status().message();
    EXPECT_EQ(*words, "");
    EXPECT_EQ(values_.import, "");
  }
  EXPECT_EQ(LineError({"--from="}), LineError({"--from", ""}));
  EXPECT_EQ(LineError({"--sfm.count="}), LineError({"--sfm.count", ""}));
  EXPECT_EQ(*Line({"--", "--sfm.import="}), "--sfm.import=");
  EXPECT_THAT(LineError({"--sfm.count", "--sfm.import="}),
              HasSubstr("needs a value"));
}

TEST_F(OptionTableTest, CommandLineSyntaxErrors) {
  EXPECT_THAT(LineError({"--sfm.count"}), HasSubstr("needs a value (1 .. 10)"));
  EXPECT_THAT(LineError({"--sfm.count", "--json"}), HasSubstr("needs a value"));
  EXPECT_THAT(LineError({"--json=1"}), HasSubstr("takes no value"));
  EXPECT_THAT(LineError({"--from", ""}), HasSubstr("--from has an empty"));
  EXPECT_THAT(LineError({"--sfm.coumt", "1"}),
              HasSubstr("did you mean sfm.count?"));
  EXPECT_THAT(LineError({"--count", "1"}), HasSubstr("sfm.count"));
  EXPECT_THAT(LineError({"--ingest.count", "1"}), HasSubstr("sfm.count"));
  EXPECT_THAT(LineError({"--sed", "1"}), HasSubstr("did you mean seed?"));
  // No guessing of abbreviations: a new option must not change a meaning.
  EXPECT_THAT(LineError({"--sfm.c", "1"}), HasSubstr("unknown option"));
  EXPECT_THAT(LineError({"--zzzzzzzzzzzz", "1"}), Not(HasSubstr("did you")));
  // A failed line changes nothing.
  EXPECT_EQ(values_.count, 3);
}

TEST_F(OptionTableTest, ConfigFile) {
  ASSERT_TRUE(Config("\xef\xbb\xbf# comment\r\n[sfm]\r\ncount = 4 # four\r\n"
                     "mode=slow\nimport = some folder/x\n[general]\nseed = 9")
                  .ok());
  EXPECT_EQ(values_.count, 4);
  EXPECT_EQ(values_.mode, "slow");
  EXPECT_EQ(values_.seed, 9);
  EXPECT_EQ(values_.import, "/w/some folder/x");
}

TEST_F(OptionTableTest, ConfigErrorsNameTheFile) {
  EXPECT_THAT(ConfigError("[sfm]\ncount = 40\n"),
              AllOf(HasSubstr("/w/config.ini"), HasSubstr("1 .. 10")));
  EXPECT_THAT(ConfigError("[sfm]\ncuont = 4\n"),
              AllOf(HasSubstr("/w/config.ini"), HasSubstr("sfm.count")));
  EXPECT_THAT(ConfigError("[sfm\ncount = 4\n"), HasSubstr("/w/config.ini"));
  EXPECT_THAT(ConfigError("[sfm]\nnonsense\n"), HasSubstr("nonsense"));
  EXPECT_THAT(ConfigError("[sfm]\ncount = 4\ncount = 5\n"),
              HasSubstr("set twice"));
  EXPECT_THAT(ConfigError("[sfm]\n# a\ncount = 4#5\n"),
              HasSubstr("line 3: # begins a comment"));
  // Words without a section belong to the command line alone.
  EXPECT_THAT(ConfigError("json = true\n"), HasSubstr("json"));
  EXPECT_EQ(values_.count, 3);
}

TEST_F(OptionTableTest, MissingConfigFileIsBadInput) {
  EXPECT_EQ(table_.ParseConfigFile("/no/such/file").status().code(),
            StatusCode::kBadInput);
}

TEST_F(OptionTableTest, LaterSettingsOverrideEarlierOnes) {
  ASSERT_TRUE(table_
                  .Apply({{"sfm.count", "2", "preset fast"},
                          {"sfm.count", "3", "config.ini"},
                          {"sfm.count", "4", "command line"}})
                  .ok());
  EXPECT_EQ(values_.count, 4);
  const Status status = table_.Apply({{"sfm.count", "0", "preset fast"}});
  EXPECT_THAT(status.message(), HasSubstr("preset fast"));
  EXPECT_FALSE(table_.Apply({{"no.such", "0", "preset fast"}}).ok());
}

TEST_F(OptionTableTest, RelativePathOnCommandLineStartsAtCurrentFolder) {
  ASSERT_TRUE(Line({"--sfm.import", "../x"}).ok());
  EXPECT_EQ(
      values_.import,
      (std::filesystem::current_path() / "../x").lexically_normal().string());
  // The folder above a link is the one above what it leads to.
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder / "far/deep");
  std::filesystem::create_directory_symlink("far/deep", folder / "link");
  ASSERT_TRUE(Line({"--sfm.import", (folder / "link/../x").string()}).ok());
  EXPECT_EQ(values_.import,
            (std::filesystem::canonical(folder.path()) / "far/x").string());
  ASSERT_TRUE(Line({"--sfm.import", ""}).ok());
  EXPECT_EQ(values_.import, "");
}

TEST_F(OptionTableTest, AProgramIsANameOrAPath) {
  ASSERT_TRUE(Config("[sfm]\ncolmap = bin/colmap\n").ok());
  EXPECT_EQ(values_.colmap, "/w/bin/colmap");
  ASSERT_TRUE(Config("[sfm]\ncolmap = colmap\n").ok());
  EXPECT_EQ(values_.colmap, "colmap");
  ASSERT_TRUE(Line({"--sfm.colmap", "./colmap"}).ok());
  EXPECT_EQ(values_.colmap,
            (std::filesystem::current_path() / "colmap").string());
  ASSERT_TRUE(Line({"--sfm.colmap", "colmap"}).ok());
  EXPECT_EQ(values_.colmap, "colmap");
}

TEST_F(OptionTableTest, ValuesOfASection) {
  const auto all = table_.Values("sfm", /*results_only=*/false);
  EXPECT_EQ(all.size(), 7u);
  EXPECT_EQ(all.at("sfm.fraction"), "0.25");
  const auto results = table_.Values("sfm", /*results_only=*/true);
  EXPECT_FALSE(results.contains("sfm.mode"));
  EXPECT_FALSE(results.contains("sfm.import"));
  EXPECT_TRUE(results.contains("sfm.count"));
}

TEST_F(OptionTableTest, DoublesRoundTripThroughText) {
  for (const char* text : {"0.1", "1", "0.3333333333333333", "1e-15"}) {
    ASSERT_TRUE(Line({"--sfm.fraction", text}).ok());
    const std::string shown = table_.Find("sfm.fraction")->value();
    const double before = values_.fraction;
    ASSERT_TRUE(Line({"--sfm.fraction", shown}).ok());
    EXPECT_EQ(values_.fraction, before);
  }
}

TEST_F(OptionTableTest, TemplateWithCommentsRemovedGivesTheDefaults) {
  std::string text = table_.ConfigTemplate();
  EXPECT_THAT(text, HasSubstr("[sfm]\n# Cameras from photographs.\n"));
  EXPECT_THAT(text, HasSubstr("\n#count = 3\n"));
  EXPECT_THAT(text, HasSubstr("# Allowed: 1 .. 10.\n"));
  ASSERT_TRUE(Config(text).ok());
  // "#count = 3" -> "count = 3": every line must be valid as it stands.
  for (size_t at = 0; (at = text.find("\n#", at)) != std::string::npos; ++at) {
    if (text[at + 2] != ' ') text.erase(at + 1, 1);
  }
  const auto before = table_.Values("sfm", false);
  ASSERT_TRUE(Config(text).ok());
  EXPECT_EQ(table_.Values("sfm", false), before);
}

TEST_F(OptionTableTest, TemplateNamesTheValuesOfPresets) {
  table_.NotePreset("rough", "sfm.count", "1");
  ASSERT_TRUE(table_.Check().ok());
  EXPECT_THAT(table_.ConfigTemplate(),
              HasSubstr("# Allowed: 1 .. 10.\n# Preset rough: 1.\n#count"));
  table_.NotePreset("rough", "sfm.cuont", "1");
  EXPECT_THAT(table_.Check().message(), HasSubstr("sfm.cuont"));
}

TEST_F(OptionTableTest, AliasesStandForNames) {
  EXPECT_EQ(table_.ResolveAlias("seed"), "general.seed");
  EXPECT_EQ(table_.ResolveAlias("general.seed"), "general.seed");
  EXPECT_EQ(table_.ResolveAlias("no.such"), "no.such");
  EXPECT_THAT(LineError({"--sfm.count", "--seed"}), HasSubstr("needs a value"));
  EXPECT_THAT(LineError({"--seed"}), HasSubstr("needs a value (at least 0)"));
}

TEST_F(OptionTableTest, OptionsThatTheCommandLineDoesNotTake) {
  table_.LimitCommandLine({"general", "sfm.mode"});
  EXPECT_TRUE(Line({"--seed", "2", "--sfm.mode", "slow", "--json"}).ok());
  EXPECT_THAT(LineError({"--sfm.count", "2"}), HasSubstr("no difference"));
  EXPECT_THAT(LineError({"--count", "2"}), Not(HasSubstr("did you mean")));
  EXPECT_TRUE(Config("[sfm]\ncount = 4\n").ok());
  EXPECT_EQ(values_.count, 4);
  table_.LimitCommandLine({"sfm"});
  EXPECT_THAT(LineError({"--seed", "2"}), HasSubstr("no difference"));
}

TEST(OptionTableDefinitionTest, MistakesInTheTableAreReported) {
  int a = 5;
  OptionTable twice;
  twice.Add("x.a", &a, {});
  twice.Add("x.a", &a, {});
  EXPECT_THAT(twice.Check().message(), HasSubstr("defined twice"));
  EXPECT_FALSE(twice.ParseCommandLine({}).ok());

  OptionTable outside;
  outside.Add("x.a", &a, {.max = 4});
  EXPECT_THAT(outside.Check().message(), HasSubstr("default"));

  OptionTable alias;
  alias.AddAlias("a", "x.a");
  EXPECT_FALSE(alias.Check().ok());
}

}  // namespace
}  // namespace freegs::pipeline
