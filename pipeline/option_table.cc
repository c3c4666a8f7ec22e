// SPDX-License-Identifier: BSD-3-Clause

#include "pipeline/option_table.h"

#include <algorithm>
#include <cstdlib>
#include <set>
#include <sstream>
#include <system_error>

#include <boost/program_options.hpp>

#include "core/io/files.h"
#include "pipeline/option_value.h"

namespace freegs::pipeline {
namespace {

namespace fs = std::filesystem;
namespace po = boost::program_options;

constexpr uint64_t kMaxConfigBytes = 1 << 20;

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
  if (value.empty()) return value;
  std::error_code error;
  const fs::path base = folder.empty() ? fs::current_path(error) : folder;
  return (base / value).lexically_normal().string();
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
  const std::string source = "command line";
  po::options_description description;
  const auto describe = [&description](const std::string& name,
                                       bool is_switch) {
    // The description owns its values.
    description.add_options()(
        name.c_str(),
        is_switch ? new po::untyped_value(/*zero_tokens=*/true)
                  : static_cast<po::value_semantic*>(po::value<std::string>()));
  };
  const auto is_bool = [](const Option& option) {
    return std::holds_alternative<bool*>(option.target);
  };
  for (const Option& option : options_) {
    if (option.on_command_line) describe(option.name, option.is_switch());
  }
  for (const auto& [alias, name] : aliases_) {
    if (Find(name)->on_command_line) describe(alias, is_bool(*Find(name)));
  }

  CommandLine line;
  try {
    using Style = po::command_line_style::style_t;
    const po::parsed_options parsed =
        po::command_line_parser(arguments)
            .options(description)
            .style(Style::allow_long | Style::long_allow_adjacent |
                   Style::long_allow_next)
            .run();
    for (const po::option& given : parsed.options) {
      if (given.position_key >= 0) {
        for (const std::string& word : given.value) {
          if (!word.empty()) continue;
          return InvalidArgumentError(
              "an argument is empty; is a variable of a script not set?");
        }
        line.positional.insert(
            line.positional.end(), given.value.begin(), given.value.end());
        continue;
      }
      const auto alias = aliases_.find(given.string_key);
      OptionSetting setting{
          alias == aliases_.end() ? given.string_key : alias->second,
          given.value.empty() ? "true" : given.value.front(),
          source};
      // "--a --b" lacks a's value rather than giving it the text "--b".
      const std::string word = setting.value.substr(0, setting.value.find('='));
      if (word.starts_with("--") &&
          (Find(word.substr(2)) || aliases_.contains(word.substr(2)))) {
        return InvalidArgumentError("option --" + given.string_key +
                                    " needs a value before " + word);
      }
      // An option of a stage may be emptied on purpose.
      if (setting.value.empty() && Find(setting.name)->section().empty()) {
        return InvalidArgumentError(
            "option --" + given.string_key +
            " has an empty value; is a variable of a script not set?");
      }
      if (Find(setting.name)->spec.is_path) {
        setting.value = ResolvePath(setting.value, "");
      }
      FREEGS_RETURN_IF_ERROR(CheckSetting(setting));
      line.settings.push_back(std::move(setting));
    }
  } catch (const po::unknown_option& e) {
    return UnknownOption(StripDashes(e.get_option_name()), source);
  } catch (const po::invalid_command_line_syntax& e) {
    const std::string name = StripDashes(e.get_option_name());
    const auto alias = aliases_.find(name);
    const Option* option = Find(alias == aliases_.end() ? name : alias->second);
    const bool extra =
        e.kind() == po::invalid_command_line_syntax::extra_parameter;
    return InvalidArgumentError(
        "option --" + name +
        (extra
             ? " takes no value"
             : " needs a value" +
                   (option == nullptr ? "" : " (" + option->Allowed() + ")")));
  } catch (const po::error& e) {
    return InvalidArgumentError(source + ": " + e.what());
  }
  return line;
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
  std::vector<OptionSetting> settings;
  std::set<std::string> seen;
  try {
    // Editors of another system put a byte order mark before the first line.
    std::istringstream stream(text.starts_with("\xef\xbb\xbf") ? text.substr(3)
                                                               : text);
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
      if (Find(setting.name)->spec.is_path) {
        setting.value = ResolvePath(setting.value, folder);
      }
      FREEGS_RETURN_IF_ERROR(CheckSetting(setting));
      settings.push_back(std::move(setting));
    }
  } catch (const po::unknown_option& e) {
    return UnknownOption(StripDashes(e.get_option_name()), source);
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

Status OptionTable::CheckSetting(const OptionSetting& setting) const {
  const Option* option = Find(setting.name);
  if (option == nullptr) return UnknownOption(setting.name, setting.source);
  const Status status = ParseOptionText(
      setting.value, option->spec, option->target, /*store=*/false);
  if (status.ok()) return status;
  return InvalidArgumentError("option " + setting.name + " (" + setting.source +
                              "): " + status.message() +
                              "; allowed: " + option->Allowed());
}

Status OptionTable::UnknownOption(const std::string& name,
                                  const std::string& source) const {
  const bool command_line = source == "command line";
  if (command_line && (Find(name) != nullptr || aliases_.contains(name))) {
    return InvalidArgumentError(source + ": option " + name +
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
  return InvalidArgumentError(source + ": unknown option " + name +
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
