// SPDX-License-Identifier: BSD-3-Clause

#include "stages/command_line/options_reference.h"

#include <string_view>
#include <variant>

namespace freegs::stages {
namespace {

using pipeline::OptionTable;

constexpr char kPageBegin[] = R"(# All options of the stages

An option is given as `--SECTION.KEY VALUE` on the command line, or as `KEY = VALUE` below `[SECTION]` in
`WORKSPACE/config.ini`. The command line wins over the file, and the file over the preset
([command_line.md](command_line.md)). Each name below is a KEY of its section; a name after it that begins with `--` is
a short form for the command line.

Options of a command itself, such as `--from` of `run`, are in `freegs_pipeline COMMAND --help`.

*This page is what `freegs_pipeline manual options` prints; a test compares them. After a change of options:
`freegs_pipeline manual options > docs/options.md`.*
)";

// Text within a table: characters that mean something in Markdown do not here.
std::string Escaped(std::string_view text) {
  std::string result;
  for (const char c : text) {
    if (std::string_view("\\|*_`<>[]").find(c) != std::string_view::npos) {
      result += '\\';
    }
    result += c;
  }
  return result;
}

// The text as code. In a table even there a | must be escaped.
std::string Code(std::string_view text) {
  std::string result = "`";
  for (const char c : text) result += c == '|' ? "\\|" : std::string(1, c);
  return result + "`";
}

std::string Values(const OptionTable::Option& option) {
  if (std::holds_alternative<bool*>(option.target)) return "`true`, `false`";
  std::string choices;
  for (const std::string& choice : option.spec.choices) {
    choices += (choices.empty() ? "" : ", ") + Code(choice);
  }
  if (!choices.empty()) return choices;
  if (std::holds_alternative<std::string*>(option.target)) {
    return option.Allowed();
  }
  const std::string kind = std::holds_alternative<double*>(option.target)
                               ? "a number"
                               : "a whole number";
  return option.spec.min || option.spec.max ? kind + ", " + option.Allowed()
                                            : kind;
}

std::string Row(const OptionTable& table, const OptionTable::Option& option) {
  std::string names = Code(option.key());
  for (const auto& [alias, name] : table.aliases()) {
    if (name == option.name) names += ", " + Code("--" + alias);
  }
  std::string presets;
  for (const auto& [preset, value] : option.preset_values) {
    presets += (presets.empty() ? "" : ", ") + preset + ": " + Code(value);
  }
  const std::string first =
      option.default_value.empty() ? "empty" : Code(option.default_value);
  return "| " + names + " | " + Values(option) + " | " + first + " | " +
         presets + " | " + Escaped(option.spec.help) + " |\n";
}

}  // namespace

std::string OptionsReference(const OptionTable& table) {
  std::string text = kPageBegin;
  for (const auto& [section, about] : table.sections()) {
    if (section.empty()) continue;
    std::string rows;
    for (const OptionTable::Option& option : table.options()) {
      if (option.section() == section) rows += Row(table, option);
    }
    if (rows.empty()) continue;
    text += "\n## " + section + "\n\n";
    if (!about.empty()) text += Escaped(about) + "\n\n";
    text += "| key | values | default | presets | what it does |\n";
    text += "|---|---|---|---|---|\n" + rows;
  }
  return text;
}

}  // namespace freegs::stages
