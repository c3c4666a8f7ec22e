// SPDX-License-Identifier: BSD-3-Clause

#include "stages/suite/ini_sections.h"

#include <exception>
#include <sstream>

#include <boost/program_options/parsers.hpp>
#include <boost/property_tree/ini_parser.hpp>
#include <boost/property_tree/ptree.hpp>

#include "core/text.h"

namespace freegs::stages {
namespace {

constexpr size_t kMaxBytes = 1 << 20;

Status LineError(const std::string& source,
                 size_t line,
                 const std::string& what) {
  return InvalidArgumentError(source + ": line " + std::to_string(line) + ": " +
                              what);
}

// The text without comments, line for line. Sections without a key, which the
// parser below would drop, are an error.
StatusOr<std::string> WithoutComments(const std::string& text,
                                      const std::string& source) {
  std::istringstream lines{std::string(WithoutByteOrderMark(text))};
  std::string result;
  std::string line;
  size_t number = 0;
  size_t empty_since = 0;  // The line of a section that has no key so far.
  while (std::getline(lines, line)) {
    ++number;
    for (const char c : line) {
      if (static_cast<unsigned char>(c) < ' ' && c != '\t' && c != '\r') {
        return LineError(source, number, "holds a control character");
      }
    }
    const size_t comment = line.find('#');
    if (comment != std::string::npos && line.find('=') < comment &&
        line[comment - 1] != ' ' && line[comment - 1] != '\t') {
      // The value would be cut without a word.
      return LineError(source,
                       number,
                       "# begins a comment: write a blank before it; no value "
                       "can hold one");
    }
    line = Trimmed(line.substr(0, comment));
    if (line.starts_with('[')) {
      if (!line.ends_with(']')) {
        return LineError(source, number, "a section is [KIND] or [KIND NAME]");
      }
      if (empty_since > 0) {
        return LineError(
            source, empty_since, "this section has no KEY = VALUE");
      }
      empty_since = number;
    } else if (!line.empty()) {
      empty_since = 0;
    }
    result += line + "\n";
  }
  if (empty_since > 0) {
    return LineError(source, empty_since, "this section has no KEY = VALUE");
  }
  return result;
}

}  // namespace

const std::string* IniSection::Find(const std::string& key) const {
  for (const auto& [name, value] : entries) {
    if (name == key) return &value;
  }
  return nullptr;
}

std::string IniSection::Title() const {
  return "[" + kind + (name.empty() ? "" : " " + name) + "]";
}

StatusOr<std::vector<IniSection>> ParseIniSections(const std::string& text,
                                                   const std::string& source) {
  if (text.size() > kMaxBytes) {
    return InvalidArgumentError(source + ": larger than 1 MiB");
  }
  FREEGS_ASSIGN_OR_RETURN(const std::string plain,
                          WithoutComments(text, source));
  boost::property_tree::ptree tree;
  try {
    std::istringstream stream(plain);
    boost::property_tree::read_ini(stream, tree);
  } catch (const boost::property_tree::ini_parser_error& e) {
    return LineError(source,
                     e.line(),
                     e.message() +
                         "; lines are [KIND NAME], KEY = VALUE, or comments "
                         "after #");
  }
  std::vector<IniSection> sections;
  for (const auto& [title, keys] : tree) {
    if (keys.empty()) {
      return InvalidArgumentError(source + ": " + title +
                                  " stands before the first section");
    }
    IniSection section;
    const size_t space = title.find_first_of(" \t");
    section.kind = title.substr(0, space);
    if (space != std::string::npos) {
      section.name = Trimmed(title.substr(space));
    }
    for (const auto& [key, value] : keys) {
      section.entries.emplace_back(key, value.data());
    }
    sections.push_back(std::move(section));
  }
  return sections;
}

StatusOr<std::string> ExpandVariables(const std::string& text,
                                      const LookUpFn& look_up) {
  std::string result;
  size_t at = 0;
  while (true) {
    const size_t begin = text.find("${", at);
    result += text.substr(at, begin - at);
    if (begin == std::string::npos) return result;
    const size_t end = text.find('}', begin);
    if (end == std::string::npos) {
      return InvalidArgumentError("'" + text + "' has a ${ without its }");
    }
    const std::string name = text.substr(begin + 2, end - begin - 2);
    const std::optional<std::string> value = look_up(name);
    if (!value) {
      return InvalidArgumentError("the variable " + name + " is not set");
    }
    result += *value;
    at = end + 1;
  }
}

StatusOr<std::vector<std::string>> SplitWords(const std::string& text) {
  try {
    return boost::program_options::split_unix(text);
  } catch (const std::exception&) {
    return InvalidArgumentError("'" + text +
                                "' has a quote or an escape "
                                "without its end");
  }
}

}  // namespace freegs::stages
