// SPDX-License-Identifier: BSD-3-Clause

#include "stages/command_line/bash_completion.h"

#include <map>
#include <utility>

#include "core/text.h"
#include "stages/command_line/completion_values.h"

namespace freegs::stages {
namespace {

constexpr char kBegin[] = R"(# Completion of freegs_pipeline for bash.
# Written by `freegs_pipeline completion bash`.
)";

// bash splits "--a=b" into three words, so a "=" among them is passed over.
// `count` is the number of values of an option that are still to come.
constexpr char kEnd[] = R"(
_freegs_pipeline_offer() {
  case $kind in
    words)
      mapfile -t COMPREPLY < <(compgen -W "$choices" -- "$cur")
      ;;
    files)
      compopt -o filenames 2>/dev/null
      mapfile -t COMPREPLY < <(compgen -f -- "$cur")
      ;;
    folders)
      compopt -o filenames 2>/dev/null
      mapfile -t COMPREPLY < <(compgen -d -- "$cur")
      ;;
  esac
}

_freegs_pipeline() {
  local cur=${COMP_WORDS[COMP_CWORD]} command=${COMP_WORDS[1]}
  local kind='' choices='' options='' word
  local -i count=0 position=1 i
  COMPREPLY=()
  [[ $cur == '=' ]] && cur=''
  if ((COMP_CWORD == 1)); then
    kind=words choices="$_freegs_pipeline_commands help --help --version"
    _freegs_pipeline_offer
    return
  fi
  for ((i = 2; i < COMP_CWORD; i++)); do
    word=${COMP_WORDS[i]}
    if [[ $word == '=' ]]; then
      continue
    elif ((count > 0)); then
      count=count-1
    elif [[ $word == -?* ]]; then
      _freegs_pipeline_values "$command" "$word"
    else
      position=position+1
    fi
  done
  if ((count == 0)); then
    _freegs_pipeline_options "$command"
    kind=words choices=$options
    [[ $cur == -* ]] || _freegs_pipeline_arguments "$command" "$position"
  fi
  _freegs_pipeline_offer
}

complete -F _freegs_pipeline freegs_pipeline
)";

// Sets the variables `kind` and `choices` of the script.
std::string Assignments(const std::vector<std::string>& choices,
                        Completion completion) {
  std::string words;
  for (const std::string& choice : choices) {
    words += (words.empty() ? "" : " ") + choice;
  }
  if (!words.empty()) return "kind=words choices=" + ShellQuoted(words);
  if (completion == Completion::kFiles) return "kind=files";
  return completion == Completion::kFolders ? "kind=folders" : "kind=none";
}

// One arm of a `case` for each text of `arms`, with all its patterns.
std::string CaseArms(
    const std::map<std::string, std::vector<std::string>>& arms) {
  std::string text;
  for (const auto& [assignments, patterns] : arms) {
    std::string line = "    ";
    for (size_t k = 0; k < patterns.size(); ++k) {
      line += (k > 0 ? " | \\\n      " : "") + ShellQuoted(patterns[k]);
    }
    text += line + ")\n      " + assignments + "\n      ;;\n";
  }
  return text;
}

}  // namespace

std::string BashCompletion(const std::vector<CommandWords>& commands) {
  std::string names;
  std::string options;
  std::map<std::string, std::vector<std::string>> values;
  std::map<std::string, std::vector<std::string>> arguments;
  for (const CommandWords& words : commands) {
    const std::string& command = words.name();
    names += (names.empty() ? "" : " ") + command;
    std::string of_command;
    for (const CompletedOption& option : CompletedOptions(words)) {
      of_command += (of_command.empty() ? "" : " ") + option.word;
      const size_t count = option.value_names.size();
      const std::string assignments =
          "count=" + std::to_string(count) + " " +
          Assignments(option.choices, option.completion);
      values[count == 0 ? "count=0" : assignments].push_back(command + " " +
                                                             option.word);
    }
    options += "    " + command +
               ")\n      options=" + ShellQuoted(of_command) + "\n      ;;\n";
    for (size_t k = 0; k < words.arguments().size(); ++k) {
      const Argument& argument = words.arguments()[k];
      arguments[Assignments(argument.choices, CompletionOf(argument.name))]
          .push_back(command + " " + std::to_string(k + 1));
    }
  }
  arguments["kind=words choices=$_freegs_pipeline_commands"].push_back(
      "help 1");
  // What is not listed has one value, for which nothing is offered.
  values.erase("count=1 kind=none");
  return std::string(kBegin) +
         "\n_freegs_pipeline_commands=" + ShellQuoted(names) +
         "\n\n_freegs_pipeline_options() {\n  case $1 in\n" + options +
         "  esac\n}\n\n_freegs_pipeline_values() {\n  case \"$1 $2\" in\n" +
         CaseArms(values) +
         "    *)\n      count=1 kind=none\n      ;;\n  esac\n}\n"
         "\n_freegs_pipeline_arguments() {\n  case \"$1 $2\" in\n" +
         CaseArms(arguments) + "  esac\n}\n" + kEnd;
}

}  // namespace freegs::stages
