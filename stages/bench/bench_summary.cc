// SPDX-License-Identifier: BSD-3-Clause

#include "stages/bench/bench_summary.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "core/io/json_text.h"
#include "core/number_text.h"
#include "stages/bench/bench_names.h"
#include "stages/bench/reference.h"

namespace freegs::stages {
namespace {

// Cells that one row of a table is about.
struct Row {
  std::vector<std::string> keys;  // The values of the table's keys.
  std::vector<size_t> cells;
};

bool Has(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

bool IsSelected(const BenchResults& bench,
                const SuiteSelection& selection,
                const SuiteCell& cell) {
  const std::string& scene = bench.suite.scenes[cell.scene].name;
  return (selection.scenes.empty() || Has(selection.scenes, scene)) &&
         (selection.grids.empty() || Has(selection.grids, cell.grid));
}

// The keys that tell rows apart: those with more than one value that no mean is
// taken over.
std::vector<std::string> RowKeys(const BenchResults& bench,
                                 const SuiteTable& table) {
  std::vector<std::string> all = {"scene", "grid"};
  const std::vector<std::string> keys = GridKeys(bench.suite);
  all.insert(all.end(), keys.begin(), keys.end());
  all.emplace_back("seed");
  std::vector<std::string> result;
  for (const std::string& key : all) {
    if (Has(table.over, key)) continue;
    std::vector<std::string> values;
    for (const SuiteCell& cell : bench.cells) {
      if (!IsSelected(bench, table, cell)) continue;
      const std::string value = KeyText(bench.suite, cell, key);
      if (!Has(values, value)) values.push_back(value);
    }
    if (values.size() > 1 || key == "scene") result.push_back(key);
  }
  // The titles of means need a column; a key without a name has no values.
  if (result.empty() && !table.means.empty()) result.emplace_back();
  return result;
}

std::vector<Row> Rows(const BenchResults& bench,
                      const SuiteTable& table,
                      const std::vector<std::string>& keys) {
  std::vector<Row> rows;
  for (size_t i = 0; i < bench.cells.size(); ++i) {
    if (!IsSelected(bench, table, bench.cells[i])) continue;
    std::vector<std::string> values;
    for (const std::string& key : keys) {
      values.push_back(KeyText(bench.suite, bench.cells[i], key));
    }
    auto row = std::find_if(rows.begin(), rows.end(), [&](const Row& known) {
      return known.keys == values;
    });
    if (row == rows.end()) row = rows.insert(rows.end(), {values, {}});
    row->cells.push_back(i);
  }
  return rows;
}

// How many digits the mean of these values has after its point; their spread
// has as many. Counts that are all the same have none.
int Digits(const std::string& name,
           double mean,
           const std::vector<double>& values) {
  if (name.starts_with(kKeptPrefix)) return 0;
  const bool one_count =
      std::all_of(values.begin(), values.end(), [&values](double value) {
        return value == values[0] && value == std::round(value);
      });
  const double size = std::abs(mean);
  return one_count ? 0 : size < 2 ? 3 : size < 100 ? 2 : 0;
}

std::string Number(double value, int digits, const std::string& name) {
  if (name.ends_with("bytes")) return FormatBytes(value);
  return FormatFixed(value, digits);
}

// The beginning of a text.
std::string ShortText(const std::string& text) {
  constexpr size_t kLength = 160;
  if (text.size() <= kLength) return text;
  const size_t end = text.rfind(' ', kLength);
  return ValidUtf8(text.substr(0, end == std::string::npos ? kLength : end)) +
         " ...";
}

// The different words of cells, one after another; nothing when the name is not
// that of words.
std::optional<std::string> Words(const BenchResults& bench,
                                 const std::vector<size_t>& cells,
                                 const std::string& name) {
  std::vector<std::string> words;
  for (const size_t i : cells) {
    const std::optional<std::string> text = WordsOf(bench.results[i], name);
    if (!text) return std::nullopt;
    const std::string word = ShortText(*text);
    if (!word.empty() && !Has(words, word)) words.push_back(word);
  }
  std::string text;
  for (const std::string& word : words) {
    text += (text.empty() ? "" : "; ") + word;
  }
  return text;
}

bool AnyIsDone(const BenchResults& bench, const std::vector<size_t>& cells) {
  return std::any_of(cells.begin(), cells.end(), [&bench](size_t i) {
    return bench.results[i].status == CellStatus::kDone;
  });
}

// Mean of a figure over cells, and its spread if that is asked for. A run that
// failed ended in the middle of a stage and did not reach others, so no mean is
// taken of its figures and those of whole runs.
std::string Field(const BenchResults& bench,
                  const std::vector<size_t>& cells,
                  const std::string& name,
                  bool with_spread) {
  if (const auto words = Words(bench, cells, name)) return *words;
  const bool only_done = AnyIsDone(bench, cells);
  std::vector<double> values;
  for (const size_t i : cells) {
    if (only_done && bench.results[i].status != CellStatus::kDone) continue;
    const auto value = bench.results[i].values.find(name);
    if (value != bench.results[i].values.end()) {
      values.push_back(value->second);
    }
  }
  if (values.empty()) return "";
  double mean = 0;
  for (const double value : values) {
    mean += value / static_cast<double>(values.size());
  }
  double spread = 0;
  for (const double value : values) {
    spread = std::max(spread, std::abs(value - mean));
  }
  const int digits = Digits(name, mean, values);
  std::string text = Number(mean, digits, name);
  if (with_spread && values.size() > 1) {
    text += " ±" + Number(spread, digits, name);
  }
  if (values.size() < cells.size()) {
    text += " (" + std::to_string(values.size()) + " of " +
            std::to_string(cells.size()) + ")";
  }
  return text;
}

// Text that does not end a field of a table.
std::string Escaped(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '|') result += '\\';
    result += c == '\n' || c == '\r' ? ' ' : c;
  }
  return result;
}

void AddLine(const std::vector<std::string>& fields, std::string* text) {
  *text += "|";
  for (const std::string& field : fields) *text += " " + Escaped(field) + " |";
  *text += "\n";
}

void AddTable(const BenchResults& bench,
              const SuiteTable& table,
              std::string* text) {
  const std::vector<std::string> keys = RowKeys(bench, table);
  const std::vector<Row> rows = Rows(bench, table, keys);
  *text += "\n## " + Escaped(table.title) + "\n\n";
  std::vector<std::string> fields = keys;
  fields.insert(fields.end(), table.columns.begin(), table.columns.end());
  AddLine(fields, text);
  AddLine(std::vector<std::string>(fields.size(), "---"), text);
  const bool with_spread = !Has(table.over, "scene");
  for (const Row& row : rows) {
    fields = row.keys;
    for (const std::string& column : table.columns) {
      fields.push_back(Field(bench, row.cells, column, with_spread));
    }
    AddLine(fields, text);
  }
  for (const auto& [title, scenes] : table.means) {
    std::vector<size_t> cells;
    for (size_t i = 0; i < bench.cells.size(); ++i) {
      if (IsSelected(bench, table, bench.cells[i]) &&
          Has(scenes, bench.suite.scenes[bench.cells[i].scene].name)) {
        cells.push_back(i);
      }
    }
    fields.assign(keys.size(), "");
    fields[0] = title;
    for (const std::string& column : table.columns) {
      fields.push_back(Field(bench, cells, column, /*with_spread=*/false));
    }
    AddLine(fields, text);
  }
}

SuiteTable DefaultTable() {
  SuiteTable table;
  table.title = "All cells";
  table.columns = {
      "total.wall_seconds", "total.cpu_seconds", "holdout_psnr", "scene_bytes"};
  return table;
}

void AddFailures(const BenchResults& bench, std::string* text) {
  bool first = true;
  for (size_t i = 0; i < bench.cells.size(); ++i) {
    const CellResult& result = bench.results[i];
    if (result.status != CellStatus::kFailed) continue;
    if (first) *text += "\n## Failed\n\n";
    first = false;
    *text += "- " + bench.cells[i].id + ": stage " + result.failed_stage +
             ", exit code " + std::to_string(result.exit_code) + ": " +
             Escaped(result.reason) + "\n";
  }
}

}  // namespace

std::string SummaryMarkdown(const BenchResults& bench) {
  std::string text = "# " + Escaped(bench.suite.title) + "\n";
  if (!IsOfOneProgram(bench)) {
    text += "\nThese cells are of more than one build of the program.\n";
  }
  for (const SuiteTable& table : bench.suite.tables) {
    AddTable(bench, table, &text);
  }
  if (bench.suite.tables.empty()) AddTable(bench, DefaultTable(), &text);
  AddFailures(bench, &text);
  return text;
}

}  // namespace freegs::stages
