// SPDX-License-Identifier: BSD-3-Clause

#include "tests/docs/workspace_page.h"

#include <regex>
#include <sstream>
#include <vector>

#include <nlohmann/json.hpp>

#include "tests/temporary_folder.h"

namespace freegs::docs {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

std::vector<std::string> CodeIn(const std::string& text) {
  static const std::regex kCode("`([^`]+)`");
  std::vector<std::string> all;
  for (std::sregex_iterator at(text.begin(), text.end(), kCode), end; at != end;
       ++at) {
    all.push_back((*at)[1]);
  }
  return all;
}

// An expression for the files that a pattern stands for. Names are in capital
// letters, with none beside them.
std::string Expression(const std::string& pattern) {
  static const std::vector<std::pair<std::string, std::string>> kNames = {
      {"VIEW", ".+"},
      {"PHOTO", ".+"},
      {"ID", "[0-9]+"},
      {"N", "[0-9]+"},
      {"HASH", "[0-9a-f]+"},
      {"STAGE", "[a-z]+"}};
  std::string text = std::regex_replace(pattern, std::regex("\\."), "\\.");
  text = std::regex_replace(text, std::regex("\\*"), "[^/]*");
  for (const auto& [name, expression] : kNames) {
    text = std::regex_replace(
        text,
        std::regex("(^|[^A-Za-z\\[])" + name + "(?![A-Za-z])"),
        "$1" + expression);
  }
  return text;
}

// Objects whose keys are not fields but names of options, files, photos.
bool HasOwnKeys(const std::string& field) {
  static const std::set<std::string> kMaps = {"settings",
                                              "options",
                                              "other_options",
                                              "inputs",
                                              "outputs",
                                              "summary",
                                              "evidence",
                                              "unregistered_reasons",
                                              "step_seconds"};
  return kMaps.contains(field);
}

void CollectFields(const json& value, std::set<std::string>* fields) {
  if (value.is_array()) {
    for (const json& element : value) {
      if (!element.is_structured()) break;
      CollectFields(element, fields);
    }
  }
  if (!value.is_object()) return;
  for (const auto& [name, member] : value.items()) {
    fields->insert(name);
    if (!HasOwnKeys(name)) CollectFields(member, fields);
  }
}

std::set<std::string> FieldsOf(const fs::path& file) {
  std::set<std::string> fields;
  const std::string text = ReadText(file);
  if (file.extension() == ".csv") {
    std::istringstream header(text.substr(0, text.find('\n')));
    for (std::string column; std::getline(header, column, ',');) {
      fields.insert(column);
    }
  } else if (file.extension() == ".json") {
    const json root = json::parse(text, nullptr, false);
    if (root.is_discarded()) return {"(no JSON)"};
    CollectFields(root, &fields);
    if (root.is_object() && root.contains("summary")) {
      for (const auto& [name, member] : root["summary"].items()) {
        fields.insert(name);
      }
    }
  }
  return fields;
}

}  // namespace

WorkspacePage::WorkspacePage(const fs::path& page) {
  std::istringstream lines(ReadText(page));
  Section* section = nullptr;
  for (std::string line; std::getline(lines, line);) {
    const std::vector<std::string> code = CodeIn(line);
    code_.insert(code.begin(), code.end());
    if (line.starts_with("#")) {
      section = line.starts_with("### ") && !code.empty() ? &sections_[code[0]]
                                                          : nullptr;
      continue;
    }
    if (section != nullptr) section->named.insert(code.begin(), code.end());
    if (!line.starts_with("| `")) continue;
    for (const std::string& name : CodeIn(line.substr(0, line.find('|', 1)))) {
      if (section != nullptr) {
        section->rows.insert(name);
      } else {
        patterns_[name] = Expression(name);
      }
    }
  }
  for (const auto& [name, of_it] : sections_)
    patterns_[name] = Expression(name);
}

std::string WorkspacePage::PatternOf(const std::string& file) const {
  for (const auto& [pattern, expression] : patterns_) {
    if (std::regex_match(file, std::regex(expression))) return pattern;
  }
  return "";
}

void WorkspacePage::Compare(const fs::path& workspace) {
  for (const auto& entry : fs::recursive_directory_iterator(workspace)) {
    if (!entry.is_regular_file()) continue;
    const std::string file = entry.path().lexically_relative(workspace);
    const std::string pattern = PatternOf(file);
    if (pattern.empty()) {
      unnamed_.insert(file);
      continue;
    }
    found_.insert(pattern);
    if (file.starts_with('.')) continue;  // Only the program reads it.
    const auto section = sections_.find(pattern);
    for (const std::string& field : FieldsOf(entry.path())) {
      if (fs::is_regular_file(workspace / "ingest/photos" / field)) continue;
      // Figures of a summary have the names that another file gives them.
      const bool anywhere =
          section == sections_.end() || pattern == "STAGE/stage.json";
      if (!(anywhere ? code_ : section->second.named).contains(field)) {
        unnamed_.insert(file + ": " + field);
      }
      found_.insert(pattern + ": " + field);
    }
  }
}

std::set<std::string> WorkspacePage::Missing() const {
  std::set<std::string> missing;
  for (const auto& [pattern, expression] : patterns_) {
    if (!found_.contains(pattern)) missing.insert(pattern);
  }
  for (const auto& [pattern, section] : sections_) {
    if (!found_.contains(pattern)) continue;
    for (const std::string& field : section.rows) {
      const std::string name = pattern + ": " + field;
      if (!found_.contains(name)) missing.insert(name);
    }
  }
  return missing;
}

}  // namespace freegs::docs
