// SPDX-License-Identifier: BSD-3-Clause

#include "stages/suite/suite.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <set>
#include <system_error>

#include "core/io/files.h"
#include "pipeline/workspace.h"
#include "stages/suite/ini_sections.h"
#include "stages/suite/section_reader.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kMaxSuiteBytes = 1 << 20;
constexpr size_t kMaxNameLength = 60;
constexpr size_t kMaxSeeds = 1000;
constexpr size_t kMaxSections = 1000;

// Names become parts of file names.
bool IsName(const std::string& name) {
  return !name.empty() && name.size() <= kMaxNameLength && name[0] != '.' &&
         std::all_of(name.begin(), name.end(), [](unsigned char c) {
           return std::isalnum(c) != 0 || c == ' ' || c == '.' || c == '_' ||
                  c == '-' || c == '+' || c >= 0x80;
         });
}

template <typename T>
Status ParseNumber(const std::string& text, T* number) {
  const char* const end = text.data() + text.size();
  const auto [rest, fault] = std::from_chars(text.data(), end, *number);
  if (rest == end && fault == std::errc() && !text.empty()) return Status();
  return InvalidArgumentError("'" + text + "' is not a number in range");
}

SectionReader::OtherFn TakeSettings(std::vector<SuiteSetting>* settings) {
  return [settings](const std::string& key, const std::string& value) {
    settings->emplace_back(key, value);
    return Status();
  };
}

Status ReadSeeds(const std::string& value, std::vector<int64_t>* seeds) {
  FREEGS_ASSIGN_OR_RETURN(const std::vector<std::string> words,
                          SplitWords(value));
  if (words.empty() || words.size() > kMaxSeeds) {
    return InvalidArgumentError("give 1 to 1000 seeds");
  }
  seeds->clear();
  for (const std::string& word : words) {
    int64_t seed = 0;
    FREEGS_RETURN_IF_ERROR(ParseNumber(word, &seed));
    if (seed < 0) return InvalidArgumentError("seed " + word + " is negative");
    if (std::count(seeds->begin(), seeds->end(), seed) > 0) {
      return InvalidArgumentError("seed " + word + " is there twice");
    }
    seeds->push_back(seed);
  }
  return Status();
}

Status ReadSuiteSection(const IniSection& section, Suite* suite) {
  SectionReader reader;
  reader.OnText("title", &suite->title);
  reader.OnText("to", &suite->to);
  reader.OnText("reference", &suite->reference);
  reader.On("seeds", [suite](const std::string& value) {
    return ReadSeeds(value, &suite->seeds);
  });
  reader.On("limit", [suite](const std::string& value) {
    FREEGS_RETURN_IF_ERROR(ParseNumber(value, &suite->time_limit_s));
    if (!(suite->time_limit_s >= 0) || std::isinf(suite->time_limit_s)) {
      return InvalidArgumentError("the limit is seconds, at least 0");
    }
    return Status();
  });
  return reader.Read(section, TakeSettings(&suite->settings));
}

// Titles that differ in white space have the same name.
template <typename T>
Status CheckNewName(const IniSection& section, const std::vector<T>& others) {
  const auto same = [&section](const T& other) {
    return other.name == section.name;
  };
  if (std::none_of(others.begin(), others.end(), same)) return Status();
  return InvalidArgumentError(section.Title() + ": is there twice");
}

Status ReadScene(const IniSection& section, Suite* suite) {
  FREEGS_RETURN_IF_ERROR(CheckNewName(section, suite->scenes));
  SuiteScene scene;
  scene.name = section.name;
  const auto path = [suite](fs::path* target) {
    return [suite, target](const std::string& value) {
      *target = pipeline::AbsolutePath(suite->folder / value);
      // "photos/shelf/" is the same folder as "photos/shelf".
      if (!target->has_filename()) *target = target->parent_path();
      return value.empty() ? InvalidArgumentError("no path") : Status();
    };
  };
  SectionReader reader;
  reader.On("images", path(&scene.images));
  reader.On("truth", path(&scene.truth));
  reader.OnWords("draw", &scene.draw);
  FREEGS_RETURN_IF_ERROR(reader.Read(section, TakeSettings(&scene.settings)));
  if (scene.images.empty() == scene.draw.empty()) {
    return InvalidArgumentError(section.Title() +
                                ": give its photographs, by images = FOLDER "
                                "or by draw = ARGUMENTS of freegs_make_scene");
  }
  for (const std::string& word : scene.draw) {
    if (word == "--out" || word.starts_with("--out=")) {
      return InvalidArgumentError(section.Title() +
                                  ": the bench chooses --out itself");
    }
  }
  if (!scene.draw.empty() && !scene.truth.empty()) {
    return InvalidArgumentError(section.Title() +
                                ": a drawn scene brings its own truth");
  }
  suite->scenes.push_back(std::move(scene));
  return Status();
}

Status ReadGrid(const IniSection& section, Suite* suite) {
  FREEGS_RETURN_IF_ERROR(CheckNewName(section, suite->grids));
  SuiteGrid grid{section.name, {}};
  SectionReader reader;
  reader.On("seeds", [&grid](const std::string& value) {
    return ReadSeeds(value, &grid.seeds);
  });
  const auto take = [&grid](const std::string& key, const std::string& value) {
    std::vector<std::string> values;
    FREEGS_RETURN_IF_ERROR(ParseWords(value, &values));
    std::set<std::string> seen;
    for (const std::string& given : values) {
      if (!seen.insert(given).second) {
        return InvalidArgumentError(given + " is there twice");
      }
    }
    grid.axes.emplace_back(key, std::move(values));
    return Status();
  };
  FREEGS_RETURN_IF_ERROR(reader.Read(section, take));
  suite->grids.push_back(std::move(grid));
  return Status();
}

void ReadSelection(SuiteSelection* selection, SectionReader* reader) {
  reader->OnText("title", &selection->title);
  reader->OnWords("scenes", &selection->scenes);
  reader->OnWords("grids", &selection->grids);
  reader->OnWords("over", &selection->over);
}

Status ReadChart(const IniSection& section, Suite* suite) {
  SuiteChart chart;
  chart.name = section.name;
  chart.title = section.name;
  SectionReader reader;
  ReadSelection(&chart, &reader);
  reader.OnText("x", &chart.x);
  reader.OnText("y", &chart.y);
  reader.OnWords("series", &chart.series);
  reader.OnText("label", &chart.label);
  reader.OnBool("log_x", &chart.log_x);
  reader.OnBool("log_y", &chart.log_y);
  reader.On("better", [&chart](const std::string& value) {
    chart.better = value;
    return value == "higher" || value == "lower"
               ? Status()
               : InvalidArgumentError("higher or lower");
  });
  FREEGS_RETURN_IF_ERROR(reader.Read(section));
  if (chart.x.empty() || chart.y.empty()) {
    return InvalidArgumentError(section.Title() + ": give x and y");
  }
  suite->charts.push_back(std::move(chart));
  return Status();
}

Status ReadTable(const IniSection& section, Suite* suite) {
  SuiteTable table;
  table.name = section.name;
  table.title = section.name;
  SectionReader reader;
  ReadSelection(&table, &reader);
  reader.OnWords("columns", &table.columns);
  for (const auto& [key, value] : section.entries) {
    if (!key.starts_with("mean ")) continue;
    reader.On(key, [&table, title = key](const std::string& text) {
      std::vector<std::string> scenes;
      FREEGS_RETURN_IF_ERROR(ParseWords(text, &scenes));
      table.means.emplace_back(title, std::move(scenes));
      return Status();
    });
  }
  FREEGS_RETURN_IF_ERROR(reader.Read(section));
  if (table.columns.empty()) {
    return InvalidArgumentError(section.Title() + ": give columns");
  }
  suite->tables.push_back(std::move(table));
  return Status();
}

// The scenes and grids that charts and tables name must be there.
Status CheckSelection(const Suite& suite,
                      const SuiteSelection& selection,
                      const std::string& title) {
  for (const std::string& name : selection.scenes) {
    if (std::none_of(suite.scenes.begin(),
                     suite.scenes.end(),
                     [&](const auto& scene) { return scene.name == name; })) {
      return InvalidArgumentError(title + ": there is no [scene " + name + "]");
    }
  }
  for (const std::string& name : selection.grids) {
    if (std::none_of(suite.grids.begin(),
                     suite.grids.end(),
                     [&](const auto& grid) { return grid.name == name; })) {
      return InvalidArgumentError(title + ": there is no [grid " + name + "]");
    }
  }
  return Status();
}

Status ReadSection(const IniSection& section, Suite* suite) {
  if (section.kind == "suite" && section.name.empty()) {
    return ReadSuiteSection(section, suite);
  }
  if (!IsName(section.name)) {
    return InvalidArgumentError(
        section.Title() +
        ": a name has letters, digits, spaces and . _ - +, at most 60");
  }
  if (section.kind == "scene") return ReadScene(section, suite);
  if (section.kind == "grid") return ReadGrid(section, suite);
  if (section.kind == "chart") return ReadChart(section, suite);
  if (section.kind == "table") return ReadTable(section, suite);
  return InvalidArgumentError(section.Title() +
                              ": sections are [suite], [scene NAME], [grid "
                              "NAME], [chart NAME] and [table NAME]");
}

}  // namespace

StatusOr<Suite> ParseSuite(const std::string& text, const fs::path& source) {
  Suite suite;
  std::error_code error;
  suite.name = source.stem().string();
  suite.folder = fs::absolute(source, error).parent_path();
  FREEGS_ASSIGN_OR_RETURN(const std::vector<IniSection> sections,
                          ParseIniSections(text, source.string()));
  if (sections.size() > kMaxSections) {
    return InvalidArgumentError(source.string() + ": more than 1000 sections");
  }
  for (const IniSection& section : sections) {
    const Status status = ReadSection(section, &suite);
    if (!status.ok()) return status.Annotated(source.string());
  }
  if (suite.scenes.empty()) {
    return InvalidArgumentError(source.string() + ": there is no [scene NAME]");
  }
  if (suite.title.empty()) suite.title = suite.name;
  if (suite.grids.empty()) suite.grids.push_back({"defaults", {}});
  if (!suite.reference.empty()) {
    SuiteSelection selection;
    selection.grids = {suite.reference};
    FREEGS_RETURN_IF_ERROR(CheckSelection(
        suite, selection, source.string() + ": [suite] reference"));
  }
  for (const SuiteChart& chart : suite.charts) {
    FREEGS_RETURN_IF_ERROR(CheckSelection(
        suite, chart, source.string() + ": [chart " + chart.name + "]"));
  }
  for (const SuiteTable& table : suite.tables) {
    FREEGS_RETURN_IF_ERROR(CheckSelection(
        suite, table, source.string() + ": [table " + table.name + "]"));
    for (const auto& [title, scenes] : table.means) {
      SuiteSelection selection;
      selection.scenes = scenes;
      FREEGS_RETURN_IF_ERROR(CheckSelection(
          suite, selection, source.string() + ": [table " + table.name + "]"));
    }
  }
  return suite;
}

StatusOr<Suite> ReadSuite(const fs::path& path) {
  FREEGS_ASSIGN_OR_RETURN(const std::string text,
                          ReadFile(path, kMaxSuiteBytes));
  return ParseSuite(text, path);
}

}  // namespace freegs::stages
