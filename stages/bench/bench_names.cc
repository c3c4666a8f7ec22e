// SPDX-License-Identifier: BSD-3-Clause

#include "stages/bench/bench_names.h"

#include <algorithm>
#include <iterator>

#include "pipeline/option_value.h"

namespace freegs::stages {
namespace {

using Names = std::vector<std::string>;

struct WordName {
  const char* name;
  std::string (*of)(const CellResult& result);
};

const WordName kWordNames[] = {
    {"ended", EndedText},
    {"status",
     [](const CellResult& r) -> std::string {
       return CellStatusName(r.status);
     }},
    {"exit_code",
     [](const CellResult& r) { return std::to_string(r.exit_code); }},
    {"failed_stage", [](const CellResult& r) { return r.failed_stage; }},
    {"reason", [](const CellResult& r) { return r.reason; }},
    {"verdict", [](const CellResult& r) { return r.verdict; }},
    {"noticed", [](const CellResult& r) { return r.told.stage; }},
    {"told", [](const CellResult& r) { return r.told.text; }}};

Names KeysOf(const Suite& suite) {
  Names keys = GridKeys(suite);
  keys.insert(keys.end(), {"scene", "grid", "seed"});
  return keys;
}

// Adds a line for each name that is not known. `place` is where it stands, and
// `fault` what is said of it.
void AddUnknown(const std::string& place,
                const std::string& fault,
                const Names& names,
                const Names& known,
                Names* lines) {
  for (const std::string& name : names) {
    if (name.empty() ||
        std::find(known.begin(), known.end(), name) != known.end()) {
      continue;
    }
    const std::string nearest = pipeline::NearestName(name, known);
    lines->push_back(
        place + ": " + fault + " " + name +
        (nearest.empty() ? "" : "; did you mean " + nearest + "?"));
  }
}

}  // namespace

std::optional<std::string> WordsOf(const CellResult& result,
                                   const std::string& name) {
  const auto* const found = std::find_if(
      std::begin(kWordNames), std::end(kWordNames), [&](const WordName& word) {
        return word.name == name;
      });
  if (found == std::end(kWordNames)) return std::nullopt;
  return found->of(result);
}

Names UnknownKeys(const Suite& suite) {
  const Names known = KeysOf(suite);
  const std::string fault = "there is no key";
  Names lines;
  for (const SuiteChart& chart : suite.charts) {
    const std::string place = "[chart " + chart.name + "]: ";
    AddUnknown(place + "label", fault, {chart.label}, known, &lines);
    AddUnknown(place + "series", fault, chart.series, known, &lines);
    AddUnknown(place + "over", fault, chart.over, known, &lines);
  }
  for (const SuiteTable& table : suite.tables) {
    AddUnknown(
        "[table " + table.name + "]: over", fault, table.over, known, &lines);
  }
  return lines;
}

Names UnknownFigures(const BenchResults& bench) {
  Names lines;
  if (std::none_of(bench.results.begin(),
                   bench.results.end(),
                   [](const CellResult& result) {
                     return result.status == CellStatus::kDone;
                   })) {
    return lines;
  }
  const Names figures = FigureNames(bench);
  // An axis takes keys whose values are numbers, a column takes words.
  Names axes = KeysOf(bench.suite);
  axes.insert(axes.end(), figures.begin(), figures.end());
  Names columns = figures;
  for (const WordName& word : kWordNames) columns.emplace_back(word.name);
  const std::string fault = "no cell has";
  for (const SuiteChart& chart : bench.suite.charts) {
    const std::string place = "[chart " + chart.name + "]: ";
    AddUnknown(place + "x", fault, {chart.x}, axes, &lines);
    AddUnknown(place + "y", fault, {chart.y}, axes, &lines);
  }
  for (const SuiteTable& table : bench.suite.tables) {
    AddUnknown("[table " + table.name + "]: columns",
               fault,
               table.columns,
               columns,
               &lines);
  }
  return lines;
}

}  // namespace freegs::stages
