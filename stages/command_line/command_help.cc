// SPDX-License-Identifier: BSD-3-Clause

#include "stages/command_line/command_help.h"

#include <algorithm>
#include <sstream>

namespace freegs::stages {
namespace {

using pipeline::OptionTable;

constexpr size_t kColumns = 80;
constexpr size_t kNameIndent = 2;
constexpr size_t kTextIndent = 6;

std::string Indented(const std::string& text, size_t indent) {
  return WrapText(text, std::string(indent, ' '), indent);
}

std::string OptionHelp(const CommandWords& words,
                       const OptionTable::Option& option) {
  const std::string names = OptionNames(words, option);
  const bool shows_choices = names.find('|') != std::string::npos;
  return Indented(names, kNameIndent) +
         Indented(option.spec.help + OptionFacts(option, shows_choices),
                  kTextIndent);
}

std::string ListOptionHelp(const CommandWords& words,
                           const ListOption& option) {
  return Indented(words.OptionUsage(option.name), kNameIndent) +
         Indented(option.help +
                      (option.repeats ? " It may be given several times." : ""),
                  kTextIndent);
}

// The options of one section that are for the command line; "" is the command's
// own.
std::string SectionHelp(const CommandWords& words, const std::string& section) {
  std::string text;
  for (const OptionTable::Option& option : words.table().options()) {
    if (option.section() == section && option.on_command_line) {
      text += OptionHelp(words, option);
    }
  }
  return text;
}

}  // namespace

std::string OptionNames(const CommandWords& words,
                        const OptionTable::Option& option) {
  std::string names;
  for (const auto& [letter, name] : words.letters()) {
    if (name == option.name) names += std::string("-") + letter + ", ";
  }
  names += words.OptionUsage(option.name);
  for (const auto& [alias, name] : words.table().aliases()) {
    if (name == option.name) names += ", --" + alias;
  }
  return names;
}

std::string CommaList(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) {
    text += (text.empty() ? "" : ", ") + word;
  }
  return text;
}

std::string OptionFacts(const OptionTable::Option& option, bool shows_choices) {
  if (option.is_switch()) return "";
  std::string facts;
  const auto add = [&facts](const std::string& fact) {
    facts += (facts.empty() ? "" : "; ") + fact;
  };
  if (option.spec.shows_default && !option.default_value.empty()) {
    add("default " + option.default_value);
  }
  if (option.spec.min || option.spec.max) add(option.Allowed());
  if (!option.spec.choices.empty() && !shows_choices) {
    add("one of " + CommaList(option.spec.choices));
  }
  std::string presets;
  for (const auto& [preset, value] : option.preset_values) {
    presets += (presets.empty() ? "preset " : ", ") + preset + ": " + value;
  }
  if (!presets.empty()) add(presets);
  return facts.empty() ? "" : " [" + facts + "]";
}

std::string WrapText(const std::string& text,
                     const std::string& first,
                     size_t indent) {
  std::istringstream input(text);
  std::string result;
  std::string line = first;
  bool empty = true;  // Whether no word stands on the line.
  for (std::string word; input >> word;) {
    if (!empty && line.size() + 1 + word.size() > kColumns) {
      result += line + "\n";
      line.assign(indent, ' ');
      empty = true;
    }
    line += (empty ? "" : " ") + word;
    empty = false;
  }
  return result + line + "\n";
}

std::string CommandHelp(const CommandWords& words) {
  std::string text = WrapText(words.Usage(), "freegs_pipeline ", 4) + "\n" +
                     Indented(words.summary(), 0);
  if (!words.arguments().empty()) text += "\nArguments:\n";
  for (const Argument& argument : words.arguments()) {
    text += Indented(argument.name, kNameIndent);
    std::string help = argument.help;
    if (!argument.choices.empty()) {
      help += " [one of " + CommaList(argument.choices) + "]";
    }
    text += Indented(help, kTextIndent);
  }
  std::string own;
  for (const ListOption& option : words.list_options()) {
    own += ListOptionHelp(words, option);
  }
  own += SectionHelp(words, "");
  if (!own.empty()) text += "\nOptions:\n" + own;
  if (words.refers_to().empty()) {
    for (const auto& [section, about] : words.table().sections()) {
      const std::string options =
          section.empty() ? "" : SectionHelp(words, section);
      if (options.empty()) continue;
      text += "\n" + WrapText(about, "[" + section + "] ", 0) + options;
    }
  } else {
    text += "\n" + Indented(
                       "It also takes every option --SECTION.KEY that "
                       "freegs_pipeline " +
                           words.refers_to() + " --help lists.",
                       0);
  }
  for (const std::string& note : words.notes()) {
    text += "\n" + Indented(note, 0);
  }
  return text;
}

std::string ProgramHelp(const std::vector<CommandWords>& commands) {
  std::string text =
      Indented(
          "freegs_pipeline: a folder of photographs becomes a 3D scene "
          "that knows its objects.",
          0) +
      "\n";
  for (const CommandWords& words : commands) {
    text += WrapText(words.Usage(), "  freegs_pipeline ", kTextIndent) +
            Indented(words.summary(), kTextIndent);
  }
  return text +
         "  freegs_pipeline --version\n\n"
         "freegs_pipeline COMMAND --help tells all about a command. The "
         "options "
         "of the\nstages (--SECTION.KEY VALUE, also in WORKSPACE/config.ini) "
         "are listed by\nfreegs_pipeline run --help.\n\n"
         "Exit codes: 0 done; 1 program or system fault; 2 wrong usage; 3 bad "
         "input;\n4 no usable result; 5 a missing program or model file; 130 "
         "interrupted.\n";
}

}  // namespace freegs::stages
