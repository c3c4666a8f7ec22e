// SPDX-License-Identifier: BSD-3-Clause

#include "stages/suite/suite.h"

#include <cstdlib>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "stages/suite/ini_sections.h"
#include "tests/temporary_folder.h"

namespace freegs::stages {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Pair;

constexpr char kSuite[] = R"ini(
# A comment.
[suite]
title = Two scenes # and another comment
seeds = 3 1
to = reconstruct
limit = 12.5
threads = 1

[scene fox]
images = photos/fox
truth = /truth/fox
sfm.camera = single

[scene drawn one]
draw = --scene table --views 12

[grid sizes]
reconstruct.max_image_size = 240 480
disturb = none "noise:0.05"

[chart speed]
x = reconstruct.cpu_seconds
y = holdout_psnr
series = scene grid
log_x = true
scenes = fox

[table all]
title = All
columns = holdout_psnr total.cpu_seconds
mean of both = fox "drawn one"
)ini";

std::string ErrorOf(const std::string& text) {
  return ParseSuite(text, "s.ini").status().message();
}

TEST(SuiteTest, ReadsEverything) {
  const StatusOr<Suite> suite = ParseSuite(kSuite, "/suites/two.ini");
  ASSERT_TRUE(suite.ok()) << suite.status().message();
  EXPECT_EQ(suite->name, "two");
  EXPECT_EQ(suite->title, "Two scenes");
  EXPECT_EQ(suite->to, "reconstruct");
  EXPECT_EQ(suite->time_limit_s, 12.5);
  EXPECT_THAT(suite->seeds, ElementsAre(3, 1));
  EXPECT_THAT(suite->settings, ElementsAre(Pair("threads", "1")));
  ASSERT_EQ(suite->scenes.size(), 2u);
  EXPECT_EQ(suite->scenes[0].images, "/suites/photos/fox");
  EXPECT_EQ(suite->scenes[0].truth, "/truth/fox");
  EXPECT_THAT(suite->scenes[0].settings,
              ElementsAre(Pair("sfm.camera", "single")));
  EXPECT_EQ(suite->scenes[1].name, "drawn one");
  EXPECT_THAT(suite->scenes[1].draw,
              ElementsAre("--scene", "table", "--views", "12"));
  ASSERT_EQ(suite->grids.size(), 1u);
  EXPECT_THAT(
      suite->grids[0].axes,
      ElementsAre(Pair("reconstruct.max_image_size", ElementsAre("240", "480")),
                  Pair("disturb", ElementsAre("none", "noise:0.05"))));
  ASSERT_EQ(suite->charts.size(), 1u);
  EXPECT_TRUE(suite->charts[0].log_x);
  EXPECT_FALSE(suite->charts[0].log_y);
  EXPECT_THAT(suite->charts[0].over, ElementsAre("seed"));
  ASSERT_EQ(suite->tables.size(), 1u);
  EXPECT_THAT(
      suite->tables[0].means,
      ElementsAre(Pair("mean of both", ElementsAre("fox", "drawn one"))));
}

TEST(SuiteTest, OfItsOwnItHasOnePointWithDefaults) {
  const StatusOr<Suite> suite =
      ParseSuite("[scene a]\nimages = b\n", "/suites/one.ini");
  ASSERT_TRUE(suite.ok()) << suite.status().message();
  EXPECT_EQ(suite->title, "one");
  ASSERT_EQ(suite->grids.size(), 1u);
  EXPECT_THAT(suite->grids[0].axes, IsEmpty());
}

TEST(SuiteTest, FoldersMayEndInASlash) {
  const StatusOr<Suite> suite = ParseSuite(
      "[scene a]\nimages = photos/shelf/\ntruth = t/\n", "/suites/one.ini");
  ASSERT_TRUE(suite.ok()) << suite.status().message();
  EXPECT_EQ(suite->scenes[0].images, "/suites/photos/shelf");
  EXPECT_EQ(suite->scenes[0].truth, "/suites/t");
}

TEST(SuiteTest, AGridHasSeedsOfItsOwnAndIsTheReference) {
  const StatusOr<Suite> suite = ParseSuite(
      "[suite]\nreference = as it is\n[scene a]\nimages = b\n"
      "[grid as it is]\nseeds = 4 5\n[grid g]\nsfm.camera = single\n",
      "/s.ini");
  ASSERT_TRUE(suite.ok()) << suite.status().message();
  EXPECT_EQ(suite->reference, "as it is");
  EXPECT_THAT(suite->grids[0].seeds, ElementsAre(4, 5));
  EXPECT_THAT(suite->grids[0].axes, IsEmpty());
  EXPECT_THAT(suite->grids[1].seeds, IsEmpty());
}

TEST(SuiteTest, VariablesComeFromTheEnvironment) {
  setenv("FREEGS_SUITE_TEST", "/data", 1);
  const StatusOr<Suite> suite = ParseSuite(
      "[scene a]\nimages = ${FREEGS_SUITE_TEST}/fox\n"
      "sfm.import = ${scene}/m\n",
      "/s.ini");
  ASSERT_TRUE(suite.ok()) << suite.status().message();
  EXPECT_EQ(suite->scenes[0].images, "/data/fox");
  EXPECT_EQ(suite->scenes[0].settings[0].second, "${scene}/m");
  unsetenv("FREEGS_SUITE_TEST");
  EXPECT_THAT(ErrorOf("[scene a]\nimages = ${FREEGS_SUITE_TEST}/fox\n"),
              HasSubstr("FREEGS_SUITE_TEST is not set"));
  EXPECT_THAT(ErrorOf("[scene a]\nimages = ${FREEGS\n"),
              HasSubstr("without its }"));
}

TEST(SuiteTest, FaultsNameFileSectionAndKey) {
  const std::string scene = "[scene a]\nimages = b\n";
  for (const auto& [text, fault] :
       std::vector<std::pair<std::string, std::string>>{
           {"", "s.ini: there is no [scene NAME]"},
           {"x = 1\n", "s.ini: x stands before the first section"},
           {"[scene a\n", "s.ini: line 1: a section is"},
           {"[scene a]\n[scene b]\nimages = c\n",
            "line 1: this section has no"},
           {"[scene a]\n", "line 1: this section has no"},
           {"[scene a]\nimages\n", "line 2"},
           {"[scene a]\nimages = b\nimages = c\n", "line 3: duplicate key"},
           {scene + scene, "line 3: duplicate section"},
           {"[scene a]\nsfm.camera = single\n", "[scene a]: give its photo"},
           {scene + "[scene b]\ndraw = --out /x\n", "chooses --out itself"},
           {scene + "[scene b]\ndraw = 'a\n", ""},
           {scene + "[scene ../x]\nimages = b\n", "a name has letters"},
           {scene + "[scene b/c]\nimages = b\n", "a name has letters"},
           {scene + "[room b]\nimages = b\n", "sections are"},
           {scene + "[suite]\nseeds = 1 x\n", "[suite] seeds: 'x' is not"},
           {scene + "[suite]\nseeds = 1 1\n", "seed 1 is there twice"},
           {scene + "[suite]\nseeds = 99999999999999999999\n", "in range"},
           {scene + "[suite]\nseeds = -1\n", "seed -1 is negative"},
           {scene + "[grid g]\nseeds = 1\n[grid  g]\nseeds = 2\n",
            "is there twice"},
           {scene + "[scene  a]\nimages = b\n", "is there twice"},
           {scene + "[grid g]\nseeds = 1 1\n", "[grid g] seeds: seed 1"},
           {scene + "[suite]\nreference = z\n", "no [grid z]"},
           {scene + "[suite]\nlimit = nan\n", "the limit is seconds"},
           {scene + "[grid g]\nreconstruct.iterations = 1 2 1\n", "1 is there"},
           {scene + "[grid g]\nreconstruct.iterations =\n", "no value"},
           {scene + "[chart c]\nx = a\n", "give x and y"},
           {scene + "[chart c]\nx = a\ny = b\nlog_X = true\n", "did you mean"},
           {scene + "[chart c]\nx = a\ny = b\nlog_x = yes\n", "true or false"},
           {scene + "[chart c]\nx = a\ny = b\nbetter = up\n", "higher or"},
           {scene + "[chart c]\nx = a\ny = b\ngrids = z\n", "no [grid z]"},
           {scene + "[table t]\ntitle = T\n", "give columns"},
           {scene + "[table t]\ncolumns = a\nmean x = q\n", "no [scene q]"},
           {std::string("[scene a]\nimages = b\0c\n", 23), "control"}}) {
    const StatusOr<Suite> suite = ParseSuite(text, "s.ini");
    if (fault.empty()) continue;  // Only that it does not crash.
    ASSERT_FALSE(suite.ok()) << text;
    EXPECT_EQ(suite.status().code(), StatusCode::kInvalidArgument);
    EXPECT_THAT(suite.status().message(), HasSubstr(fault)) << text;
    EXPECT_THAT(suite.status().message(), HasSubstr("s.ini")) << text;
  }
}

TEST(SuiteTest, TruncatedAndHostileTextIsAnErrorOrASuite) {
  const std::string whole = kSuite;
  for (size_t size = 0; size < whole.size(); ++size) {
    (void)ParseSuite(whole.substr(0, size), "s.ini");
  }
  EXPECT_FALSE(ParseSuite(std::string(2 << 20, 'x'), "s.ini").ok());
  EXPECT_FALSE(ParseSuite(std::string(500000, '['), "s.ini").ok());
  std::string many = "[scene a]\nimages = b\n[grid g]\nsfm.neighbours =";
  for (int i = 0; i < 120000; ++i) many += " " + std::to_string(i);
  EXPECT_THAT(ErrorOf(many), HasSubstr("more than 10000 values"));
  many.clear();
  for (int i = 0; i < 20000; ++i) {
    many += "[scene " + std::to_string(i) + "]\nimages = b\n";
  }
  EXPECT_THAT(ErrorOf(many), HasSubstr("more than 1000 sections"));
  std::string seeds = "[scene a]\nimages = b\n[suite]\nseeds =";
  for (int i = 0; i < 1001; ++i) seeds += " " + std::to_string(i);
  EXPECT_THAT(ErrorOf(seeds + "\n"), HasSubstr("1 to 1000"));
}

TEST(SuiteTest, AMissingFileIsBadInput) {
  EXPECT_EQ(ReadSuite("/there/is/none.ini").status().code(),
            StatusCode::kBadInput);
}

TEST(IniSectionsTest, WordsInQuotesStayTogether) {
  const auto words = SplitWords("a \"b c\" d");
  ASSERT_TRUE(words.ok());
  EXPECT_THAT(*words, ElementsAre("a", "b c", "d"));
}

}  // namespace
}  // namespace freegs::stages
