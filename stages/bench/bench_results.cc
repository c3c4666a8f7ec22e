// SPDX-License-Identifier: BSD-3-Clause

#include "stages/bench/bench_results.h"

#include <algorithm>
#include <fstream>
#include <set>

#include <nlohmann/json.hpp>

#include "core/io/json_text.h"
#include "pipeline/option_value.h"
#include "pipeline/system_info.h"
#include "pipeline/version.h"

namespace freegs::stages {
namespace {

using nlohmann::json;

// The processor as the system calls it; empty where it does not tell.
std::string ProcessorName() {
  std::ifstream file("/proc/cpuinfo");
  std::string line;
  while (std::getline(file, line)) {
    if (!line.starts_with("model name")) continue;
    const size_t colon = line.find(':');
    const size_t begin = line.find_first_not_of(' ', colon + 1);
    if (colon != std::string::npos && begin != std::string::npos) {
      return line.substr(begin);
    }
  }
  return "";
}

json SelectionJson(const SuiteSelection& selection) {
  return {{"name", selection.name},
          {"title", selection.title},
          {"scenes", selection.scenes},
          {"grids", selection.grids},
          {"over", selection.over}};
}

json ChartJson(const SuiteChart& chart) {
  json value = SelectionJson(chart);
  value["x"] = chart.x;
  value["y"] = chart.y;
  value["series"] = chart.series;
  value["label"] = chart.label;
  value["log_x"] = chart.log_x;
  value["log_y"] = chart.log_y;
  value["better"] = chart.better;
  return value;
}

json TableJson(const SuiteTable& table) {
  json value = SelectionJson(table);
  value["columns"] = table.columns;
  value["means"] = json::array();
  for (const auto& [title, scenes] : table.means) {
    value["means"].push_back({{"title", title}, {"scenes", scenes}});
  }
  return value;
}

std::string CsvField(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + "\"";
}

void AddCsvLine(const std::vector<std::string>& fields, std::string* csv) {
  for (size_t i = 0; i < fields.size(); ++i) {
    *csv += (i == 0 ? "" : ",") + CsvField(fields[i]);
  }
  *csv += "\r\n";
}

std::string NumberText(double value) { return pipeline::OptionText(&value); }

}  // namespace

std::vector<std::string> FigureNames(const BenchResults& bench) {
  std::set<std::string> names;
  for (const CellResult& result : bench.results) {
    for (const auto& [name, value] : result.values) names.insert(name);
  }
  return {names.begin(), names.end()};
}

bool IsOfOneProgram(const BenchResults& bench) {
  std::set<std::string> programs;
  for (const CellResult& result : bench.results) {
    programs.insert(result.programs.begin(), result.programs.end());
  }
  return programs.size() <= 1;
}

json ToJson(const BenchResults& bench) {
  const Suite& suite = bench.suite;
  json document = {{"suite", ValidUtf8(suite.name)},
                   {"title", ValidUtf8(suite.title)},
                   {"to", suite.to},
                   {"seeds", suite.seeds},
                   {"keys", GridKeys(suite)},
                   {"reference", suite.reference},
                   {"program_version", pipeline::kProgramVersion},
                   {"one_program", IsOfOneProgram(bench)},
                   {"machine",
                    {{"processor", ValidUtf8(ProcessorName())},
                     {"cores", pipeline::AvailableCores()},
                     {"memory_bytes", pipeline::Memory().total_bytes}}},
                   {"charts", json::array()},
                   {"tables", json::array()},
                   {"cells", json::array()}};
  for (const SuiteChart& chart : suite.charts) {
    document["charts"].push_back(ChartJson(chart));
  }
  for (const SuiteTable& table : suite.tables) {
    document["tables"].push_back(TableJson(table));
  }
  for (size_t i = 0; i < bench.cells.size(); ++i) {
    document["cells"].push_back(
        ToJson(suite, bench.cells[i], bench.results[i]));
  }
  return document;
}

std::string ToCsv(const BenchResults& bench) {
  const std::vector<std::string> keys = GridKeys(bench.suite);
  const std::vector<std::string> figures = FigureNames(bench);
  std::vector<std::string> fields = {"scene", "grid", "seed"};
  fields.insert(fields.end(), keys.begin(), keys.end());
  for (const char* name : {"status",
                           "exit_code",
                           "failed_stage",
                           "reason",
                           "verdict",
                           "noticed",
                           "told",
                           "folder"}) {
    fields.emplace_back(name);
  }
  fields.insert(fields.end(), figures.begin(), figures.end());
  std::string csv;
  AddCsvLine(fields, &csv);
  for (size_t i = 0; i < bench.cells.size(); ++i) {
    const SuiteCell& cell = bench.cells[i];
    const CellResult& result = bench.results[i];
    fields = {bench.suite.scenes[cell.scene].name,
              cell.grid,
              std::to_string(cell.seed)};
    for (const std::string& key : keys) {
      fields.push_back(KeyText(bench.suite, cell, key));
    }
    fields.insert(fields.end(),
                  {CellStatusName(result.status),
                   std::to_string(result.exit_code),
                   result.failed_stage,
                   result.reason,
                   result.verdict,
                   result.told.stage,
                   result.told.text,
                   result.folder});
    for (const std::string& figure : figures) {
      const auto value = result.values.find(figure);
      fields.push_back(
          value == result.values.end() ? "" : NumberText(value->second));
    }
    AddCsvLine(fields, &csv);
  }
  return csv;
}

}  // namespace freegs::stages
