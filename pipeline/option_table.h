// SPDX-License-Identifier: BSD-3-Clause
// One table defines every option: its place on the command line and in
// config.ini, its default, range and help. Built on Boost.Program_options.

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

// A value given to an option, and where: "command line", "preset fast" or the
// path of a config.ini.
struct OptionSetting {
  std::string name;
  std::string value;
  std::string source;
};

// Options live in the callers' structs: the table holds pointers to them and
// must not outlive them. Their defaults are what they hold when added.
//
// A name is SECTION.KEY, given as "--SECTION.KEY VALUE" or
// "--SECTION.KEY=VALUE" on the command line and as KEY = VALUE below [SECTION]
// in config.ini. A name without a section ("from", "json") exists on the
// command line only; if its variable is a bool it is a switch without a value.
class OptionTable {
 public:
  using Target = OptionTarget;

  struct Option {
    std::string name;
    Target target;
    OptionSpec spec;
    std::string default_value;

    std::string section() const;  // Empty if the name has none.
    std::string key() const;
    // The present value as text; reading it back gives the same value.
    std::string value() const;
    // "0 .. 1", "at least 0", "fast, balanced, quality", "true or false",
    // "text": what is allowed, for help and error messages.
    std::string Allowed() const;
  };

  struct CommandLine {
    std::vector<OptionSetting> settings;
    std::vector<std::string> positional;
  };

  // Adds an option. A name used twice or a default outside its own range is
  // reported by Check() and by everything that reads settings.
  void Add(std::string name, Target target, OptionSpec spec);

  // "--alias" means "--name" on the command line: --seed for --general.seed.
  void AddAlias(std::string alias, std::string name);

  // A sentence for the top of a section in config.ini and --help. Sections
  // appear in the order in which they are first named.
  void AddSection(std::string section, std::string help);

  Status Check() const;

  // Splits arguments into settings and positional words. Unknown options,
  // missing values and values that are not allowed are kInvalidArgument. An
  // option may be repeated: the last one wins. Changes no option.
  StatusOr<CommandLine> ParseCommandLine(
      const std::vector<std::string>& arguments) const;

  // Reads a config.ini. Errors are kInvalidArgument and name the file; a file
  // that cannot be read is kBadInput. Changes no option.
  StatusOr<std::vector<OptionSetting>> ParseConfigFile(
      const std::filesystem::path& path) const;

  // The same from text; relative paths are taken from `folder`, and messages
  // name `source`.
  StatusOr<std::vector<OptionSetting>> ParseConfig(
      const std::string& text,
      const std::filesystem::path& folder,
      const std::string& source) const;

  // Sets options in order: later settings override earlier ones, so apply
  // preset, config.ini and command line one after another. Stops at the first
  // error (kInvalidArgument naming option, fault and what is allowed).
  Status Apply(const std::vector<OptionSetting>& settings);

  const std::vector<Option>& options() const { return options_; }
  const Option* Find(std::string_view name) const;

  // Name -> present value of a section's options; with results_only, of those
  // that affect the result.
  std::map<std::string, std::string> Values(std::string_view section,
                                            bool results_only) const;

  // A config.ini with every option commented out at its default.
  std::string ConfigTemplate() const;

  // Options with defaults, ranges and help, for a terminal. With a section,
  // only that one; "" is the options without a section.
  std::string Help() const;
  std::string SectionHelp(const std::string& section) const;

 private:
  Status CheckSetting(const OptionSetting& setting) const;
  Status UnknownOption(const std::string& name,
                       const std::string& source) const;

  std::vector<Option> options_;
  std::map<std::string, size_t, std::less<>> index_;
  std::map<std::string, std::string> aliases_;
  std::vector<std::pair<std::string, std::string>> sections_;
  Status error_;
};

}  // namespace freegs::pipeline

#endif  // FREEGS_PIPELINE_OPTION_TABLE_H_
