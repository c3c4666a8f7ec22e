// SPDX-License-Identifier: BSD-3-Clause

#include "stages/suite/suite_cells.h"

#include <set>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace freegs::stages {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Pair;

// Knows two options of eval and one disturbance.
SuiteChecks KnownChecks() {
  SuiteChecks checks;
  checks.eval = [](const std::string& option,
                   const std::string&) -> StatusOr<bool> {
    if (option == "text-from") return false;
    if (option == "model") return true;
    return InvalidArgumentError("unknown");
  };
  checks.disturb = [](const std::string& text) {
    return text == "none" || text.starts_with("blur:")
               ? Status()
               : InvalidArgumentError("there is blur:PIXELS");
  };
  return checks;
}

StatusOr<std::vector<SuiteCell>> Cells(const std::string& text,
                                       const SuiteChecks& checks = {}) {
  FREEGS_ASSIGN_OR_RETURN(const Suite suite, ParseSuite(text, "/d/s.ini"));
  return MakeCells(suite, checks);
}

TEST(SuiteCellsTest, GridsAreCrossProductsAndAddUp) {
  const auto cells = Cells(
      "[suite]\nseeds = 1 2\nthreads = 1\n[scene a]\nimages = p\n"
      "[scene b]\nimages = q\n[grid g]\npreset = fast quality\n"
      "reconstruct.iterations = 10 20 30\n[grid h]\nsfm.camera = single\n");
  ASSERT_TRUE(cells.ok()) << cells.status().message();
  ASSERT_EQ(cells->size(), 2u * (2 * 3 + 1) * 2);
  std::set<std::string> ids;
  for (const SuiteCell& cell : *cells) ids.insert(cell.id);
  EXPECT_EQ(ids.size(), cells->size());
  EXPECT_EQ(cells->front().id,
            "a, grid g: preset=fast reconstruct.iterations=10, seed 1");
  EXPECT_THAT(cells->front().settings,
              ElementsAre(Pair("general.threads", "1"),
                          Pair("general.preset", "fast"),
                          Pair("reconstruct.iterations", "10")));
  EXPECT_EQ(cells->back().id, "b, grid h: sfm.camera=single, seed 2");
}

// All grids together have nine million cells. Two are too many already.
TEST(SuiteCellsTest, TooManyCellsAreRefusedBeforeTheyAreMade) {
  std::string text = "[scene a]\nimages = p\n";
  for (int grid = 0; grid < 900; ++grid) {
    text += "[grid g" + std::to_string(grid) + "]\ndisturb = none\n";
    for (const char* option : {"reconstruct.iterations",
                               "reconstruct.max_image_size",
                               "sfm.max_image_size",
                               "sfm.max_features"}) {
      text +=
          std::string(option) + " = 700 701 702 703 704 705 706 707 708 709\n";
    }
  }
  int grids = 0;
  SuiteChecks checks;
  checks.disturb = [&grids](const std::string&) {
    ++grids;
    return Status();
  };
  const auto cells = Cells(text, checks);
  ASSERT_FALSE(cells.ok());
  EXPECT_LE(grids, 2);
  EXPECT_THAT(cells.status().message(), HasSubstr("more than 10000 cells"));
}

TEST(SuiteCellsTest, AGridMayHaveSeedsOfItsOwn) {
  const auto cells = Cells(
      "[suite]\nseeds = 1\n[scene a]\nimages = p\n[grid g]\nseeds = 2 3\n"
      "[grid h]\nsfm.camera = single\n");
  ASSERT_TRUE(cells.ok()) << cells.status().message();
  ASSERT_EQ(cells->size(), 3u);
  EXPECT_EQ((*cells)[0].id, "a, grid g, seed 2");
  EXPECT_EQ((*cells)[1].seed, 3);
  EXPECT_EQ((*cells)[2].seed, 1);
}

TEST(SuiteCellsTest, PathsStartAtTheSuite) {
  const auto cells = Cells(
      "[scene a]\nimages = p\nsfm.import = model\n[scene b]\nimages = p\n"
      "sfm.import = ${scene}/model\n");
  ASSERT_TRUE(cells.ok()) << cells.status().message();
  EXPECT_THAT((*cells)[0].settings, Contains(Pair("sfm.import", "/d/model")));
  EXPECT_THAT((*cells)[1].settings,
              Contains(Pair("sfm.import", "${scene}/model")));

  // A program with a '/' is a path, and one without is looked for in PATH.
  const auto programs = Cells(
      "[scene a]\nimages = p\n"
      "[grid g]\nsfm.colmap = colmap tools/colmap ${scene}/colmap\n");
  ASSERT_TRUE(programs.ok()) << programs.status().message();
  ASSERT_EQ(programs->size(), 3u);
  EXPECT_THAT((*programs)[0].settings, Contains(Pair("sfm.colmap", "colmap")));
  EXPECT_THAT((*programs)[1].settings,
              Contains(Pair("sfm.colmap", "/d/tools/colmap")));
  EXPECT_THAT((*programs)[2].settings,
              Contains(Pair("sfm.colmap", "${scene}/colmap")));

  const auto of_eval = Cells(
      "[scene a]\nimages = p\n[grid g]\neval.model = clip ${scene}/clip\n",
      KnownChecks());
  ASSERT_TRUE(of_eval.ok()) << of_eval.status().message();
  EXPECT_THAT((*of_eval)[0].eval_options,
              ElementsAre(Pair("model", "/d/clip")));
  EXPECT_THAT((*of_eval)[1].eval_options,
              ElementsAre(Pair("model", "${scene}/clip")));
}

TEST(SuiteCellsTest, OptionsOfEvalAndDisturbancesAreApart) {
  const auto cells = Cells(
      "[scene a]\nimages = p\n[grid g]\neval.text_from = gaussians\n"
      "disturb = none blur:2\n",
      KnownChecks());
  ASSERT_TRUE(cells.ok()) << cells.status().message();
  ASSERT_EQ(cells->size(), 2u);
  EXPECT_EQ((*cells)[0].disturb, "");
  EXPECT_EQ((*cells)[1].disturb, "blur:2");
  EXPECT_THAT((*cells)[0].eval_options,
              ElementsAre(Pair("text-from", "gaussians")));
  EXPECT_TRUE((*cells)[0].settings.empty());
}

TEST(SuiteCellsTest, FaultsNameSectionAndOption) {
  const std::string scene = "[scene a]\nimages = p\n";
  for (const auto& [text, fault] :
       std::vector<std::pair<std::string, std::string>>{
           {scene + "[grid g]\nreconstruct.iteration = 1\n",
            "did you mean reconstruct.iterations"},
           {scene + "[grid g]\nreconstruct.iterations = 0\n", "[grid g]"},
           {scene + "reconstruct.iterations = many\n", "[scene a]"},
           {scene + "[suite]\nseed = 4\n", "seeds = ..."},
           {scene + "[suite]\nto = nowhere\n", "there is no stage 'nowhere'"},
           {scene + "[grid g]\ndisturb = noise:1\n", "there is blur:PIXELS"},
           {scene + "[grid g]\neval.psnr = 1\n", "eval.psnr: unknown"},
           {scene + "[grid g]\npreset = slow\n", "preset"}}) {
    const auto cells = Cells(text, KnownChecks());
    ASSERT_FALSE(cells.ok()) << text;
    EXPECT_EQ(cells.status().code(), StatusCode::kInvalidArgument) << text;
    EXPECT_THAT(cells.status().message(), HasSubstr(fault)) << text;
  }
  // Without somebody who disturbs photographs the key is unknown.
  const auto cells = Cells(scene + "[grid g]\ndisturb = blur:2\n");
  EXPECT_THAT(cells.status().message(), HasSubstr("unknown option disturb"));
}

TEST(SuiteCellsTest, ThereAreNotTooMany) {
  std::string grid = "[scene a]\nimages = p\n[grid g]\n";
  for (const char* key : {"reconstruct.iterations",
                          "reconstruct.max_image_size",
                          "reconstruct.densify_interval"}) {
    grid += std::string(key) + " =";
    for (int i = 1; i <= 100; ++i) grid += " " + std::to_string(i);
    grid += "\n";
  }
  EXPECT_THAT(Cells(grid).status().message(), HasSubstr("10000"));
}

}  // namespace
}  // namespace freegs::stages
