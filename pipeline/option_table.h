// SPDX-License-Identifier: BSD-3-Clause
// One table defines every option: its place on the command line and in
// config.ini, its default, its range and its help. It uses
// Boost.Program_options.

#ifndef FREEGS_PIPELINE_OPTION_TABLE_H_
#define FREEGS_PIPELINE_OPTION_TABLE_H_

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/status.h"
#include "pipeline/option_spec.h"

namespace freegs::pipeline {

// A value that was given to an option. `source` tells where: "command line",
// "preset fast" or the path of a config.ini.
struct OptionSetting {
  std::string name;
  std::string value;
  std::string source;
};

// All options of the program:
//
//   OptionTable table;
//   table.AddSection("sfm", "Structure from motion.");
//   table.Add("sfm.max_features",
//             &options.max_features,
//             {.help = "Features kept per photo.", .min = 1});
//   FREEGS_ASSIGN_OR_RETURN(const OptionTable::CommandLine line,
//                           table.ParseCommandLine(arguments));
//   FREEGS_RETURN_IF_ERROR(table.Apply(line.settings));
//
// The table holds pointers to variables of the caller, which must outlive it.
// The default of an option is the value of its variable when it is added.
//
// A name is SECTION.KEY. It is given as "--SECTION.KEY VALUE" or
// "--SECTION.KEY=VALUE" on the command line, and as KEY = VALUE below [SECTION]
// in config.ini. A name without a section ("from", "json") exists on the
// command line only. If its variable is a bool, it is a switch without a value.
class OptionTable {
 public:
  using Target = OptionTarget;

  struct Option {
    std::string name;
    Target target;
    OptionSpec spec;
    std::string default_value;

    // The values that presets give it: {preset, value}.
    std::vector<std::pair<std::string, std::string>> preset_values = {};

    // False where an option is for config.ini alone; see LimitCommandLine.
    bool on_command_line = true;

    std::string section() const;  // Empty if the name has none.
    std::string key() const;
    // Whether it takes no value on the command line.
    bool is_switch() const;
    // The present value as text, which reads back as the same value.
    std::string value() const;
    // What is allowed, for help and error messages: "0 .. 1", "at least 0",
    // "fast, balanced, quality", "true or false" or "text".
    std::string Allowed() const;
  };

  struct CommandLine {
    std::vector<OptionSetting> settings;
    std::vector<std::string> positional;
  };

  // Adds an option. When its name is already used, or its default lies outside
  // its range, Check() and all functions that read settings return an error.
  void Add(std::string name, Target target, OptionSpec spec);

  // Makes "--alias" mean "--name" on the command line, such as --seed for
  // --general.seed.
  void AddAlias(std::string alias, std::string name);

  // Notes that a preset gives an option this value, for help and config.ini. An
  // unknown option makes Check() fail.
  void NotePreset(const std::string& preset,
                  const std::string& name,
                  const std::string& value);

  // Keeps of all options with a section only these on the command line. A name
  // is that of an option or of a whole section. The others are still read from
  // config.ini.
  void LimitCommandLine(const std::vector<std::string>& names);

  // Adds a sentence that stands at the top of a section in config.ini and in
  // --help. Sections appear in the order in which they are first named.
  void AddSection(std::string section, std::string help);

  Status Check() const;

  // Splits arguments into settings and positional words, and changes no option.
  // Returns kInvalidArgument for unknown options, missing values, values that
  // are not allowed, empty words and empty values of options without a section.
  // Where an option of a section is repeated, the last value wins; one without
  // a section must not be repeated.
  StatusOr<CommandLine> ParseCommandLine(
      const std::vector<std::string>& arguments) const;

  // Reads the settings in a config.ini, and changes no option. Returns
  // kBadInput for a file that cannot be read and kInvalidArgument for wrong
  // content; the message names the file.
  StatusOr<std::vector<OptionSetting>> ParseConfigFile(
      const std::filesystem::path& path) const;

  // Does the same for the text of such a file. Relative paths start at
  // `folder`, and messages name `source`.
  StatusOr<std::vector<OptionSetting>> ParseConfig(
      const std::string& text,
      const std::filesystem::path& folder,
      const std::string& source) const;

  // Sets options in the order of the settings, so that later ones override
  // earlier ones: apply the preset first, then config.ini, then the command
  // line. Stops at the first error, which is kInvalidArgument and names the
  // option, the fault and what is allowed.
  Status Apply(const std::vector<OptionSetting>& settings);

  const std::vector<Option>& options() const { return options_; }
  const Option* Find(std::string_view name) const;

  // The name of the option that an alias stands for; other names stay as they
  // are.
  std::string ResolveAlias(const std::string& name) const;

  // The names that stand for an option on the command line: {alias, name}.
  const std::map<std::string, std::string>& aliases() const { return aliases_; }

  // The sections and what is said about each, in their order. Options without a
  // section are in the section "".
  const std::vector<std::pair<std::string, std::string>>& sections() const {
    return sections_;
  }

  // The present values of the options of a section, by name. With results_only
  // these are only the options that affect the result.
  std::map<std::string, std::string> Values(std::string_view section,
                                            bool results_only) const;

  // The text of a config.ini in which every option stands as a comment with its
  // default.
  std::string ConfigTemplate() const;

 private:
  // Where a setting is given. Some options are for only one of the two.
  enum class Source { kCommandLine, kFile };

  // The setting "--given value" of the command line.
  StatusOr<OptionSetting> SettingOf(const std::string& given,
                                    const std::string& value) const;
  Status CheckSetting(const OptionSetting& setting) const;
  // `place` names the source in the message.
  Status UnknownOption(const std::string& name,
                       Source source,
                       const std::string& place) const;

  std::vector<Option> options_;
  std::map<std::string, size_t, std::less<>> index_;
  std::map<std::string, std::string> aliases_;
  std::vector<std::pair<std::string, std::string>> sections_;
  Status error_;
};

}  // namespace freegs::pipeline

#endif  // FREEGS_PIPELINE_OPTION_TABLE_H_
