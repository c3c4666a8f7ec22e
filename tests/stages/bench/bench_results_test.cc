// SPDX-License-Identifier: BSD-3-Clause
// The tables of a bench, its page, and its baseline.

#include "stages/bench/bench_results.h"

#include <limits>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/io/json_fields.h"
#include "stages/bench/baseline.h"
#include "stages/bench/bench_names.h"
#include "stages/bench/bench_page.h"
#include "stages/bench/bench_summary.h"
#include "stages/bench/reference.h"

namespace freegs::stages {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

class BenchResultsTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const StatusOr<Suite> suite = ParseSuite(
        "[suite]\ntitle = A, \"B\"\nseeds = 1 2\n[scene a]\nimages = p\n"
        "[scene b]\nimages = q\n[grid g]\npreset = fast quality\n"
        "[table t]\ntitle = T\ncolumns = holdout_psnr scene_bytes\n"
        "mean of both = a b\n",
        "/d/s.ini");
    ASSERT_TRUE(suite.ok()) << suite.status().message();
    suite_ = *suite;
    const auto cells = MakeCells(suite_, {});
    ASSERT_TRUE(cells.ok()) << cells.status().message();
    cells_ = *cells;
    results_.resize(cells_.size());
    for (size_t i = 0; i < results_.size(); ++i) {
      results_[i].status = CellStatus::kDone;
      results_[i].verdict = "ok";
      results_[i].programs = {"p1"};
      results_[i].values = {{"holdout_psnr", 20.0 + static_cast<double>(i)},
                            {"scene_bytes", 5e6}};
    }
    results_[3].status = CellStatus::kFailed;
    results_[3].exit_code = 4;
    results_[3].failed_stage = "sfm";
    results_[3].reason = "no poses | </script>\nat all";
    results_[3].values = {{"sfm.wall_seconds", 1.5}};
  }

  BenchResults Bench() const { return {suite_, cells_, results_}; }

  Suite suite_;
  std::vector<SuiteCell> cells_;
  std::vector<CellResult> results_;
};

TEST_F(BenchResultsTest, CsvQuotesWhatNeedsIt) {
  const std::string csv = ToCsv(Bench());
  EXPECT_THAT(csv,
              HasSubstr("scene,grid,seed,preset,status,exit_code,failed_stage,"
                        "reason,verdict,noticed,told,folder,holdout_psnr,"
                        "scene_bytes,sfm.wall_seconds\r\n"
                        "a,g,1,fast,done,0,,,ok,,,,20,"));
  EXPECT_THAT(csv,
              HasSubstr("a,g,2,quality,failed,4,sfm,\"no poses | "
                        "</script>\nat all\",ok,,,,,,1.5\r\n"));
}

TEST_F(BenchResultsTest, JsonHasAllCells) {
  const nlohmann::json json = ToJson(Bench());
  ASSERT_EQ(json["cells"].size(), 8u);
  EXPECT_EQ(json["title"], "A, \"B\"");
  EXPECT_EQ(json["cells"][3]["status"], "failed");
  EXPECT_EQ(json["cells"][3]["point"]["preset"], "quality");
  EXPECT_EQ(json["cells"][0]["values"]["holdout_psnr"], 20.0);
  EXPECT_EQ(json["one_program"], true);
  EXPECT_EQ(json["cells"][0]["program"], "p1");
}

TEST_F(BenchResultsTest, IsOfOneProgramWhenAllStagesAre) {
  EXPECT_TRUE(IsOfOneProgram(Bench()));
  results_[1].programs = {};  // Nothing ran.
  EXPECT_TRUE(IsOfOneProgram(Bench()));
  results_[2].programs = {"p2"};
  EXPECT_FALSE(IsOfOneProgram(Bench()));
  // Each cell is of the same two.
  for (CellResult& result : results_) result.programs = {"p1", "p2"};
  EXPECT_FALSE(IsOfOneProgram(Bench()));
  EXPECT_EQ(ToJson(Bench())["one_program"], false);
  EXPECT_EQ(ToJson(Bench())["cells"][0]["program"], "p1, p2");
}

TEST_F(BenchResultsTest, SummaryHasMeansAndFailures) {
  const std::string text = SummaryMarkdown(Bench());
  EXPECT_THAT(text, HasSubstr("| scene | preset | holdout_psnr |"));
  EXPECT_THAT(text, HasSubstr("| a | fast | 20.50 ±0.50 | 5.0 MB ±0 B |"));
  EXPECT_THAT(text, HasSubstr("| a | quality | 22 (1 of 2) |"));
  EXPECT_THAT(text, HasSubstr("| mean of both |  | 23.57 (7 of 8) |"));
  EXPECT_THAT(text,
              HasSubstr("- a, grid g: preset=quality, seed 2: stage sfm, exit "
                        "code 4: no poses \\| </script> at all"));
}

TEST_F(BenchResultsTest, FiguresOfFailedCellsCountOnlyAmongThemselves) {
  suite_.tables[0].columns = {"total.cpu_seconds", "sfm.cpu_seconds"};
  for (CellResult& result : results_) {
    result.values = {{"total.cpu_seconds", 40}, {"sfm.cpu_seconds", 8}};
  }
  results_[3].values = {{"total.cpu_seconds", 9}, {"sfm.cpu_seconds", 7}};
  for (const size_t i : {6, 7}) {
    results_[i].status = CellStatus::kFailed;
    results_[i].values = results_[3].values;
  }
  const std::string text = SummaryMarkdown(Bench());
  EXPECT_THAT(text, HasSubstr("| a | fast | 40 ±0 | 8 ±0 |"));
  EXPECT_THAT(text, HasSubstr("| a | quality | 40 (1 of 2) | 8 (1 of 2) |"));
  EXPECT_THAT(text, HasSubstr("| b | quality | 9 ±0 | 7 ±0 |"));
  EXPECT_THAT(text,
              HasSubstr("| mean of both |  | 40 (5 of 8) | 8 (5 of 8) |"));
}

TEST_F(BenchResultsTest, HowCellsEndedMayBeColumns) {
  suite_.tables[0].columns = {
      "status", "exit_code", "failed_stage", "reason", "verdict"};
  const std::string text = SummaryMarkdown(Bench());
  EXPECT_THAT(text, HasSubstr("| a | fast | done | 0 |  |  | ok |"));
  EXPECT_THAT(text,
              HasSubstr("| a | quality | done; failed | 0; 4 | sfm | no poses "
                        "\\| </script> at all | ok |"));
  EXPECT_THAT(UnknownFigures(Bench()), IsEmpty());
}

TEST_F(BenchResultsTest, NamesOfNothingAreTold) {
  EXPECT_THAT(UnknownKeys(suite_), IsEmpty());
  EXPECT_THAT(UnknownFigures(Bench()), IsEmpty());
  SuiteChart chart;
  chart.name = "c";
  chart.x = "seed";
  chart.y = "holdout_pnsr";
  chart.label = "presett";
  chart.series = {"scene", "grids"};
  suite_.charts = {chart};
  suite_.tables[0].over = {"seed", "nothing.like.it"};
  suite_.tables[0].columns = {"scene_byte", "verdict"};
  EXPECT_THAT(
      UnknownKeys(suite_),
      ElementsAre("[chart c]: label: there is no key presett; did you mean "
                  "preset?",
                  "[chart c]: series: there is no key grids; did you mean "
                  "grid?",
                  "[table t]: over: there is no key nothing.like.it"));
  EXPECT_THAT(UnknownFigures(Bench()),
              ElementsAre("[chart c]: y: no cell has holdout_pnsr; did you "
                          "mean holdout_psnr?",
                          "[table t]: columns: no cell has scene_byte; did you "
                          "mean scene_bytes?"));
  // Where all failed, figures are missing for another reason.
  for (CellResult& result : results_) result.status = CellStatus::kFailed;
  EXPECT_THAT(UnknownFigures(Bench()), IsEmpty());
}

TEST_F(BenchResultsTest, MeansHaveATitleInATableWithoutKeys) {
  suite_.tables[0].over = {"seed", "scene", "preset"};
  const std::string text = SummaryMarkdown(Bench());
  EXPECT_THAT(text, HasSubstr("|  | holdout_psnr | scene_bytes |"));
  // How far scenes differ is no spread.
  EXPECT_THAT(text, HasSubstr("|  | 23.57 (7 of 8) |"));
  EXPECT_THAT(text, HasSubstr("| mean of both | 23.57 (7 of 8) |"));
}

TEST_F(BenchResultsTest, CellsAreComparedWithTheReference) {
  const StatusOr<Suite> suite = ParseSuite(
      "[suite]\nreference = none\n[scene a]\nimages = p\n"
      "[grid none]\nseeds = 1 2\npreset = fast\n"
      "[grid other]\nseeds = 3\npreset = quality\n"
      "[table t]\ncolumns = ended noticed told kept.psnr\n",
      "/d/s.ini");
  ASSERT_TRUE(suite.ok()) << suite.status().message();
  const auto cells = MakeCells(*suite, {});
  ASSERT_TRUE(cells.ok()) << cells.status().message();
  ASSERT_EQ(cells->size(), 3u);
  EXPECT_EQ((*cells)[2].seed, 3);
  std::vector<CellResult> results(3);
  results[0].status = CellStatus::kDone;
  results[0].values = {{"psnr", 19}, {"text_mbiou", 0.5}, {"text_box_miou", 1}};
  results[0].kinds = {{"ingest", "warning: 3 photos are dark"}};
  results[1].status = CellStatus::kDone;
  results[1].values = {{"psnr", 21}};
  results[2].status = CellStatus::kFailed;
  results[2].exit_code = 4;
  results[2].failed_stage = "sfm";
  results[2].values = {{"psnr", 10},
                       {"num_gaussians", 7},
                       {"text_mbiou", 0.25},
                       {"text_box_miou", 0.5}};
  results[2].kinds = {{"ingest", "warning: 14 photos are dark"},
                      {"sfm", "warning: few poses"}};
  CompareWithReference(*suite, *cells, &results);
  EXPECT_EQ(results[0].told.text, "warning: 3 photos are dark");
  EXPECT_EQ(results[2].told.text, "warning: few poses");
  EXPECT_DOUBLE_EQ(results[1].values["kept.psnr"], 105);
  EXPECT_DOUBLE_EQ(results[2].values["kept.psnr"], 50);
  EXPECT_DOUBLE_EQ(results[2].values["kept.text_mbiou"], 50);
  EXPECT_DOUBLE_EQ(results[2].values["kept.text_box_miou"], 50);
  EXPECT_FALSE(results[2].values.contains("kept.num_gaussians"));
  const std::string text = SummaryMarkdown({*suite, *cells, results});
  EXPECT_THAT(
      text, HasSubstr("| sfm: exit code 4 | sfm | warning: few poses | 50 |"));
}

// Each of twelve photographs has a warning with its name. Fewer photographs are
// no new warning, and neither are shuffled ones, which lie in folders.
TEST_F(BenchResultsTest, WhatTheReferenceWasToldIsNotNew) {
  const StatusOr<Suite> suite = ParseSuite(
      "[suite]\nreference = none\n[scene a]\nimages = p\n[grid none]\n"
      "disturb = none\n[grid other]\ndisturb = drop:0.1 shuffle\n",
      "/d/s.ini");
  ASSERT_TRUE(suite.ok()) << suite.status().message();
  SuiteChecks checks;
  checks.disturb = [](const std::string&) { return Status(); };
  const auto cells = MakeCells(*suite, checks);
  ASSERT_TRUE(cells.ok()) << cells.status().message();
  ASSERT_EQ(cells->size(), 3u);
  std::vector<CellResult> results(3);
  const std::string names = "abcdefghijkl";
  for (size_t i = 0; i < names.size(); ++i) {
    const std::string photo = names[i] + std::string(".heic: not used");
    const std::string folder = "00" + std::to_string(30 - i) + "/";
    results[0].kinds.push_back({"ingest", "warning: ingest: " + photo});
    if (i != 3) results[1].kinds.push_back(results[0].kinds.back());
    results[2].kinds.push_back(
        {"ingest", "warning: ingest: " + folder + photo});
  }
  CompareWithReference(*suite, *cells, &results);
  EXPECT_EQ(results[1].told.text, "");
  EXPECT_EQ(results[1].told.stage, "");
  EXPECT_EQ(results[2].told.text, "");
  results[2].kinds.push_back({"sfm", "warning: sfm: 0002/m.jpg is dark"});
  CompareWithReference(*suite, *cells, &results);
  EXPECT_EQ(results[2].told.text, "warning: sfm: 0002/m.jpg is dark");
  EXPECT_EQ(results[2].told.stage, "sfm");
}

TEST_F(BenchResultsTest, PageEmbedsDataSafely) {
  BenchPage page;
  page.title = "<b>";
  page.results = ToJson(Bench()).dump();
  page.summary = SummaryMarkdown(Bench());
  page.script = "go();";
  const std::string html = RenderBenchPage(page);
  EXPECT_THAT(html, HasSubstr("&lt;b&gt;"));
  EXPECT_THAT(html, HasSubstr("no poses | \\u003c/script>"));
  EXPECT_THAT(html, HasSubstr("<script>go();</script>"));
  page.script = "";
  page.missing = "not built";
  EXPECT_THAT(RenderBenchPage(page), HasSubstr("not built"));
  EXPECT_THAT(RenderBenchPage(page), Not(HasSubstr("<script")));
}

TEST_F(BenchResultsTest, BaselineComesBackFromJson) {
  const Baseline made = MakeBaseline(Bench(), {{"holdout_psnr", {0.5, 0}}});
  const StatusOr<Baseline> read = BaselineFromJson(ToJson(made), "b.json");
  ASSERT_TRUE(read.ok()) << read.status().message();
  EXPECT_EQ(read->cells, made.cells);
  EXPECT_THAT(WhatMoved(*read, made), IsEmpty());
}

TEST_F(BenchResultsTest, FaultsOfTheMachineAreNoBaseline) {
  // One cell failed with exit code 4, which is a result.
  EXPECT_TRUE(CheckForBaseline(Bench()).ok());
  for (const int code : {1, 5, -1}) {
    results_[3].exit_code = code;
    const Status status = CheckForBaseline(Bench());
    EXPECT_EQ(status.code(), StatusCode::kUnusableResult);
    EXPECT_THAT(status.message(),
                HasSubstr(cells_[3].id + " ended with exit code " +
                          std::to_string(code)));
  }
}

TEST_F(BenchResultsTest, WhatMovedIsNamed) {
  const std::map<std::string, Tolerance> tolerances = {
      {"holdout_psnr", {0.5, 0}}, {"scene_bytes", {0, 0.1}}};
  const Baseline then = MakeBaseline(Bench(), tolerances);
  results_[0].values["holdout_psnr"] += 0.4;
  results_[1].values["holdout_psnr"] -= 0.6;
  results_[2].values["scene_bytes"] *= 1.2;
  results_[4].values.erase("scene_bytes");
  results_[5].verdict = "degraded";
  const std::vector<std::string> moved =
      WhatMoved(then, MakeBaseline(Bench(), tolerances));
  EXPECT_THAT(
      moved,
      ElementsAre(
          HasSubstr("seed 2: holdout_psnr 21 -> 20.4, by more than 0.5"),
          HasSubstr("scene_bytes 5e+06 -> 6e+06, by more than 500000"),
          HasSubstr("scene_bytes is gone"),
          HasSubstr("verdict 'ok' -> 'degraded'")));
}

TEST_F(BenchResultsTest, NewAndMissingCellsAreNamed) {
  const Baseline all = MakeBaseline(Bench(), {});
  Baseline fewer = all;
  fewer.cells.erase(cells_[0].id);
  EXPECT_THAT(WhatMoved(all, fewer), ElementsAre(HasSubstr("any more")));
  EXPECT_THAT(WhatMoved(fewer, all), ElementsAre(HasSubstr("no such cell")));
}

TEST(BaselineTest, DamagedFilesAreBadInput) {
  const std::string good =
      R"({"tolerances": {"a": {"absolute": 1, "relative": 0}}, "cells":
      {"c": {"status": "done", "exit_code": 0, "verdict": "", "values":
      {"a": 3}}}})";
  const auto read = [](const std::string& text) {
    const StatusOr<nlohmann::json> json = ParseJson(text);
    return json.ok() ? BaselineFromJson(*json, "b.json").status()
                     : json.status();
  };
  ASSERT_TRUE(read(good).ok()) << read(good).message();
  for (size_t size = 0; size < good.size(); ++size) {
    EXPECT_FALSE(read(good.substr(0, size)).ok()) << size;
  }
  for (const auto& [from, to] :
       std::vector<std::pair<std::string, std::string>>{
           {"\"absolute\": 1", "\"absolute\": -1"},
           {"\"absolute\": 1", "\"absolute\": 1e999"},
           {"\"a\": 3", "\"a\": \"3\""},
           {"\"a\": 3", "\"a\": null"},
           {"\"exit_code\": 0", "\"exit_code\": 9999999999"},
           {"{\"c\": ", "[{\"c\": "},
           {"\"done\"", "[]"}}) {
    std::string bad = good;
    bad.replace(bad.find(from), from.size(), to);
    EXPECT_FALSE(read(bad).ok()) << bad;
  }
}

}  // namespace
}  // namespace freegs::stages
