// SPDX-License-Identifier: BSD-3-Clause

#include "stages/command_line/zsh_completion.h"

#include "core/text.h"
#include "stages/command_line/completion_values.h"

namespace freegs::stages {
namespace {

constexpr char kZshBegin[] = R"(#compdef freegs_pipeline
# Completion of freegs_pipeline for zsh.
# Written by `freegs_pipeline completion zsh`.

_freegs_pipeline() {
  local -a commands
  local command
)";

// A file of fpath is the body of the function when it is called first; a script
// that is sourced only defines the function.
constexpr char kZshEnd[] = R"(  esac
}

if [[ ${funcstack[1]} == _freegs_pipeline ]]; then
  _freegs_pipeline "$@"
else
  compdef _freegs_pipeline freegs_pipeline
fi
)";

// Puts a backslash before what _arguments and _describe would take for the end
// of a text.
std::string Escaped(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '[' || c == ']' || c == ':' || c == '\\') escaped += '\\';
    escaped += c;
  }
  return escaped;
}

// ":NAME:ACTION", which tells _arguments about one value.
std::string Value(const std::string& name,
                  const std::vector<std::string>& choices,
                  Completion completion) {
  std::string action = " ";
  if (!choices.empty()) {
    action = "(";
    for (const std::string& choice : choices) {
      action += (action.size() > 1 ? " " : "") + choice;
    }
    action += ")";
  } else if (completion != Completion::kNothing) {
    action = completion == Completion::kFiles ? "_files" : "_files -/";
  }
  return ":" + Escaped(name) + ":" + action;
}

std::string OptionSpecOfZsh(const CompletedOption& option) {
  std::string spec = (option.repeats ? "*" : "") + option.word;
  // "=" allows both "--from sfm" and "--from=sfm".
  const bool one_value = option.value_names.size() == 1;
  if (one_value && option.word.starts_with("--")) spec += "=";
  spec += "[" + Escaped(option.help) + "]";
  for (const std::string& name : option.value_names) {
    spec += Value(name, option.choices, option.completion);
  }
  return spec;
}

}  // namespace

std::string ZshCompletion(const std::vector<CommandWords>& commands) {
  std::string list;
  std::string names;
  std::string arms;
  for (const CommandWords& words : commands) {
    std::string summary = words.summary();
    if (summary.ends_with('.')) summary.pop_back();
    list +=
        "      " + ShellQuoted(Escaped(words.name()) + ":" + summary) + "\n";
    names += (names.empty() ? "" : " ") + words.name();
    arms += "    " + words.name() + ")\n      _arguments";
    for (const CompletedOption& option : CompletedOptions(words)) {
      arms += " \\\n        " + ShellQuoted(OptionSpecOfZsh(option));
    }
    for (size_t k = 0; k < words.arguments().size(); ++k) {
      const Argument& argument = words.arguments()[k];
      arms += " \\\n        " + ShellQuoted(std::to_string(k + 1) +
                                            Value(argument.name,
                                                  argument.choices,
                                                  CompletionOf(argument.name)));
    }
    arms += "\n      ;;\n";
  }
  std::string script = kZshBegin;
  script += "  if (( CURRENT == 2 )); then\n    commands=(\n";
  script += list;
  script +=
      "      'help:Tells about a command'\n"
      "      '--help:Tells about the program'\n"
      "      '--version:Tells the version'\n    )\n"
      "    _describe command commands\n    return\n  fi\n"
      "  command=$words[2]\n  shift words\n  (( CURRENT-- ))\n"
      "  case $command in\n";
  script += arms;
  script += "    help)\n      _arguments " +
            ShellQuoted("1:COMMAND:(" + names + ")") + "\n      ;;\n";
  return script + kZshEnd;
}

}  // namespace freegs::stages
