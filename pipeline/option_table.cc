// SPDX-License-Identifier: BSD-3-Clause

#include "pipeline/option_table.h"

#include <algorithm>
#include <cstdlib>
#include <set>
#include <sstream>
#include <system_error>

#include <boost/program_options.hpp>

#include "core/io/files.h"
#include "core/text.h"
#include "pipeline/option_value.h"
#include "pipeline/workspace.h"

namespace freegs::pipeline {
namespace {

namespace fs = std::filesystem;
namespace po = boost::program_options;

constexpr uint64_t kMaxConfigBytes = 1 << 20;
constexpr char kCommandLine[] = "command line";

// Boost takes "#" for the begin of a comment wherever it stands, so a value
// that holds one would be cut without a word.
Status CheckComments(const std::string& text, const std::string& source) {
  std::istringstream lines(text);
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    const size_t comment = line.find('#');
    if (comment == std::string::npos || comment == 0) continue;
    const bool after_value = line.find('=') < comment;
    if (!after_value || line[comment - 1] == ' ' || line[comment - 1] == '\t') {
      continue;
    }
    return InvalidArgumentError(
        source + ": line " + std::to_string(number) +
        ": # begins a comment: write a blank before it, or give a value that "
        "holds it on the command line");
  }
  return Status();
}

// Lays out text in lines of at most 78 columns, each after `prefix`.
std::string Wrap(const std::string& text, const std::string& prefix) {
  std::istringstream words(text);
  std::string result;
  std::string line;
  std::string word;
  while (words >> word) {
    if (!line.empty() &&
        prefix.size() + line.size() + 1 + word.size() > size_t{78}) {
      result += prefix + line + "\n";
      line.clear();
    }
    line += (line.empty() ? "" : " ") + word;
  }
  if (!line.empty()) result += prefix + line + "\n";
  return result;
}

std::string StripDashes(std::string name) {
  name.erase(0, name.find_first_not_of('-'));
  return name;
}

// A path as it will be used: absolute, without "." and "..".
std::string ResolvePath(const std::string& value, const fs::path& folder) {
  return value.empty() ? value : AbsolutePath(folder / value).string();
}

// The value as it will be used, whose relative paths start at `folder`.
std::string Resolved(const std::string& value,
                     const OptionSpec& spec,
                     const fs::path& folder) {
  return spec.HasPath(value) ? ResolvePath(value, folder) : value;
}

void DescribeCommandLine(const OptionTable& table,
                         po::options_description* description) {
  const auto describe = [description](const std::string& name, bool is_switch) {
    // The description owns its values.
    description->add_options()(
        name.c_str(),
        is_switch ? new po::untyped_value(/*zero_tokens=*/true)
                  : static_cast<po::value_semantic*>(po::value<std::string>()));
  };
  for (const OptionTable::Option& option : table.options()) {
    if (option.on_command_line) describe(option.name, option.is_switch());
  }
  for (const auto& [alias, name] : table.aliases()) {
    const OptionTable::Option& option = *table.Find(name);
    if (!option.on_command_line) continue;
    describe(alias, std::holds_alternative<bool*>(option.target));
  }
}

// Boost takes "--option=" for an option without a value. Here it is one with an
// empty value, as "--option" and an empty word are.
std::vector<std::string> WithEmptyValues(
    const OptionTable& table, const std::vector<std::string>& arguments) {
  std::vector<std::string> words;
  for (auto word = arguments.begin(); word != arguments.end(); ++word) {
    // What follows are no options.
    if (*word == "--") {
      words.insert(words.end(), word, arguments.end());
      break;
    }
    words.push_back(*word);
    if (!word->starts_with("--") || word->find('=') != word->size() - 1) {
      continue;
    }
    const std::string name = word->substr(0, word->size() - 1);
    const OptionTable::Option* option =
        table.Find(table.ResolveAlias(StripDashes(name)));
    if (option == nullptr || option->is_switch()) continue;
    words.back() = name;
    words.emplace_back();
  }
  return words;
}

Status SyntaxError(const OptionTable& table,
                   const po::invalid_command_line_syntax& error) {
  const std::string name = StripDashes(error.get_option_name());
  std::string fault = " takes no value";
  if (error.kind() != po::invalid_command_line_syntax::extra_parameter) {
    const OptionTable::Option* option = table.Find(table.ResolveAlias(name));
    fault = " needs a value" +
            (option == nullptr ? "" : " (" + option->Allowed() + ")");
  }
  return InvalidArgumentError("option --" + name + fault);
}

}  // namespace

std::string OptionTable::Option::section() const {
  const size_t dot = name.find('.');
  return dot == std::string::npos ? "" : name.substr(0, dot);
}

std::string OptionTable::Option::key() const {
  const size_t dot = name.find('.');
  return dot == std::string::npos ? name : name.substr(dot + 1);
}

bool OptionTable::Option::is_switch() const {
  return section().empty() && std::holds_alternative<bool*>(target);
}

std::string OptionTable::Option::value() const { return OptionText(target); }

std::string OptionTable::Option::Allowed() const {
  return AllowedText(spec, target);
}

void OptionTable::Add(std::string name, Target target, OptionSpec spec) {
  if (spec.is_path) spec.affects_result = false;
  Option option{std::move(name), target, std::move(spec), OptionText(target)};
  const std::string section = option.section();
  AddSection(section, "");
  if (error_.ok() && !index_.emplace(option.name, options_.size()).second) {
    error_ = InternalError("option " + option.name + " is defined twice");
  }
  const Status status = ParseOptionText(
      option.default_value, option.spec, option.target, /*store=*/false);
  if (error_.ok() && !status.ok()) {
    error_ = InternalError("option " + option.name + ": default " +
                           status.message() + " (" + option.Allowed() + ")");
  }
  options_.push_back(std::move(option));
}

void OptionTable::AddAlias(std::string alias, std::string name) {
  if (error_.ok() && (index_.contains(alias) || aliases_.contains(alias))) {
    error_ = InternalError("option " + alias + " is defined twice");
  }
  if (error_.ok() && !index_.contains(name)) {
    error_ =
        InternalError("option " + alias + " stands for the unknown " + name);
  }
  aliases_[std::move(alias)] = std::move(name);
}

void OptionTable::NotePreset(const std::string& preset,
                             const std::string& name,
                             const std::string& value) {
  const auto found = index_.find(name);
  if (found != index_.end()) {
    options_[found->second].preset_values.emplace_back(preset, value);
  } else if (error_.ok()) {
    error_ = InternalError("preset " + preset + " sets the unknown " + name);
  }
}

void OptionTable::LimitCommandLine(const std::vector<std::string>& names) {
  for (Option& option : options_) {
    if (option.section().empty()) continue;
    option.on_command_line = std::any_of(
        names.begin(), names.end(), [&option](const std::string& name) {
          return name == option.name || name == option.section();
        });
  }
}

void OptionTable::AddSection(std::string section, std::string help) {
  for (auto& [known, known_help] : sections_) {
    if (known == section) {
      if (!help.empty()) known_help = std::move(help);
      return;
    }
  }
  sections_.emplace_back(std::move(section), std::move(help));
}

Status OptionTable::Check() const { return error_; }

StatusOr<OptionTable::CommandLine> OptionTable::ParseCommandLine(
    const std::vector<std::string>& arguments) const {
  FREEGS_RETURN_IF_ERROR(error_);
  po::options_description description;
  DescribeCommandLine(*this, &description);
  CommandLine line;
  std::set<std::string> seen;
  try {
    using Style = po::command_line_style::style_t;
    const po::parsed_options parsed =
        po::command_line_parser(WithEmptyValues(*this, arguments))
            .options(description)
            .style(Style::allow_long | Style::long_allow_adjacent |
                   Style::long_allow_next)
            .run();
    for (const po::option& given : parsed.options) {
      if (given.position_key < 0) {
        FREEGS_ASSIGN_OR_RETURN(
            OptionSetting setting,
            SettingOf(given.string_key,
                      given.value.empty() ? "true" : given.value.front()));
        // A script may add an option of a stage to those that it has already.
        const bool again = !seen.insert(setting.name).second;
        if (again && Find(setting.name)->section().empty()) {
          return InvalidArgumentError("--" + setting.name + " is given twice");
        }
        line.settings.push_back(std::move(setting));
        continue;
      }
      for (const std::string& word : given.value) {
        if (word.empty()) {
          return InvalidArgumentError(
              "an argument is empty; is a variable of a script not set?");
        }
        line.positional.push_back(word);
      }
    }
  } catch (const po::unknown_option& e) {
    return UnknownOption(
        StripDashes(e.get_option_name()), Source::kCommandLine, kCommandLine);
  } catch (const po::invalid_command_line_syntax& e) {
    return SyntaxError(*this, e);
  } catch (const po::error& e) {
    return InvalidArgumentError(std::string(kCommandLine) + ": " + e.what());
  }
  return line;
}

StatusOr<OptionSetting> OptionTable::SettingOf(const std::string& given,
                                               const std::string& value) const {
  OptionSetting setting{ResolveAlias(given), value, kCommandLine};
  // "--a --b" lacks a's value rather than giving it the text "--b".
  const std::string word = value.substr(0, value.find('='));
  if (word.starts_with("--") && Find(ResolveAlias(word.substr(2))) != nullptr) {
    return InvalidArgumentError("option --" + given + " needs a value before " +
                                word);
  }
  const Option& option = *Find(setting.name);
  // An option of a stage may be emptied on purpose.
  if (value.empty() && option.section().empty()) {
    return InvalidArgumentError(
        "option --" + given +
        " has an empty value; is a variable of a script not set?");
  }
  setting.value = Resolved(value, option.spec, "");
  FREEGS_RETURN_IF_ERROR(CheckSetting(setting));
  return setting;
}

StatusOr<std::vector<OptionSetting>> OptionTable::ParseConfigFile(
    const fs::path& path) const {
  FREEGS_ASSIGN_OR_RETURN(const std::string text,
                          ReadFile(path, kMaxConfigBytes));
  std::error_code error;
  return ParseConfig(text, fs::absolute(path, error).parent_path(), path);
}

StatusOr<std::vector<OptionSetting>> OptionTable::ParseConfig(
    const std::string& text,
    const fs::path& folder,
    const std::string& source) const {
  FREEGS_RETURN_IF_ERROR(error_);
  po::options_description description;
  for (const Option& option : options_) {
    if (option.section().empty()) continue;
    description.add_options()(option.name.c_str(), po::value<std::string>());
  }
  FREEGS_RETURN_IF_ERROR(CheckComments(text, source));
  std::vector<OptionSetting> settings;
  std::set<std::string> seen;
  try {
    std::istringstream stream{std::string(WithoutByteOrderMark(text))};
    const po::parsed_options parsed = po::parse_config_file(
        stream, description, /*allow_unregistered=*/false);
    for (const po::option& given : parsed.options) {
      OptionSetting setting{given.string_key,
                            given.value.empty() ? "" : given.value.front(),
                            source};
      if (!seen.insert(setting.name).second) {
        return InvalidArgumentError(source + ": option " + setting.name +
                                    " is set twice: remove one of the lines");
      }
      setting.value = Resolved(setting.value, Find(setting.name)->spec, folder);
      FREEGS_RETURN_IF_ERROR(CheckSetting(setting));
      settings.push_back(std::move(setting));
    }
  } catch (const po::unknown_option& e) {
    return UnknownOption(
        StripDashes(e.get_option_name()), Source::kFile, source);
  } catch (const po::invalid_config_file_syntax& e) {
    return InvalidArgumentError(source + ": cannot understand '" + e.tokens() +
                                "': lines are [SECTION], KEY = VALUE, or "
                                "comments after #");
  } catch (const po::error& e) {
    return InvalidArgumentError(source + ": " + e.what());
  }
  return settings;
}

Status OptionTable::Apply(const std::vector<OptionSetting>& settings) {
  FREEGS_RETURN_IF_ERROR(error_);
  for (const OptionSetting& setting : settings) {
    FREEGS_RETURN_IF_ERROR(CheckSetting(setting));
    const Option& option = *Find(setting.name);
    FREEGS_RETURN_IF_ERROR(ParseOptionText(
        setting.value, option.spec, option.target, /*store=*/true));
  }
  return Status();
}

const OptionTable::Option* OptionTable::Find(std::string_view name) const {
  const auto found = index_.find(name);
  return found == index_.end() ? nullptr : &options_[found->second];
}

std::string OptionTable::ResolveAlias(const std::string& name) const {
  const auto found = aliases_.find(name);
  return found == aliases_.end() ? name : found->second;
}

Status OptionTable::CheckSetting(const OptionSetting& setting) const {
  const Option* option = Find(setting.name);
  if (option == nullptr) {
    return UnknownOption(setting.name, Source::kFile, setting.source);
  }
  const Status status = ParseOptionText(
      setting.value, option->spec, option->target, /*store=*/false);
  if (status.ok()) return status;
  return InvalidArgumentError("option " + setting.name + " (" + setting.source +
                              "): " + status.message() +
                              "; allowed: " + option->Allowed());
}

Status OptionTable::UnknownOption(const std::string& name,
                                  Source source,
                                  const std::string& place) const {
  const bool command_line = source == Source::kCommandLine;
  if (command_line && Find(ResolveAlias(name)) != nullptr) {
    return InvalidArgumentError(place + ": option " + name +
                                " makes no difference to this command");
  }
  const auto usable = [command_line](const Option& option) {
    return command_line ? option.on_command_line : !option.section().empty();
  };
  std::vector<std::string> candidates;
  for (const Option& option : options_) {
    if (usable(option)) candidates.push_back(option.name);
  }
  for (const auto& [alias, full] : aliases_) {
    if (command_line && usable(*Find(full))) candidates.push_back(alias);
  }
  // A key under the wrong section, or under none, is not a spelling mistake.
  const std::string key = name.substr(name.rfind('.') + 1);
  std::string nearest;
  for (const Option& option : options_) {
    if (!option.section().empty() && usable(option) && option.key() == key) {
      nearest = option.name;
    }
  }
  if (nearest.empty()) nearest = NearestName(name, candidates);
  return InvalidArgumentError(place + ": unknown option " + name +
                              (nearest.empty()
                                   ? "; see freegs_pipeline COMMAND --help"
                                   : "; did you mean " + nearest + "?"));
}

std::map<std::string, std::string> OptionTable::Values(
    std::string_view section, bool results_only) const {
  std::map<std::string, std::string> values;
  for (const Option& option : options_) {
    if (option.section() != section) continue;
    if (results_only && !option.spec.affects_result) continue;
    values[option.name] = option.value();
  }
  return values;
}

std::string OptionTable::ConfigTemplate() const {
  std::string text =
      "# Options of freegs_pipeline. Every line is commented out and shows "
      "the\n"
      "# default: remove the # before KEY = VALUE to change one. The command\n"
      "# line (--SECTION.KEY VALUE) wins over this file, this file over the\n"
      "# preset. Relative paths start from this file's folder.\n";
  for (const auto& [section, help] : sections_) {
    if (section.empty() || Values(section, false).empty()) continue;
    text += "\n[" + section + "]\n";
    if (!help.empty()) text += Wrap(help, "# ");
    for (const Option& option : options_) {
      if (option.section() != section) continue;
      text += "\n" + Wrap(option.spec.help, "# ");
      text += Wrap("Allowed: " + option.Allowed() + ".", "# ");
      for (const auto& [preset, value] : option.preset_values) {
        text += "# Preset " + preset + ": " + value + ".\n";
      }
      text += "#" + option.key() + " =" +
              (option.default_value.empty() ? "" : " " + option.default_value) +
              "\n";
    }
  }
  return text;
}

}  // namespace freegs::pipeline
