// SPDX-License-Identifier: BSD-3-Clause

#include "stages/commands/completion_command.h"

#include "stages/command_line/bash_completion.h"
#include "stages/command_line/zsh_completion.h"

namespace freegs::stages {

CommandWords CompletionWords() {
  CommandWords words("completion",
                     "Prints a script that makes a shell complete commands, "
                     "options and values.");
  words.AddArgument({.name = "SHELL",
                     .help = "The shell that reads the script.",
                     .choices = {"bash", "zsh"}});
  words.AddNote("In ~/.bashrc: source <(freegs_pipeline completion bash)");
  words.AddNote(
      "In ~/.zshrc, after compinit: source <(freegs_pipeline completion zsh)");
  return words;
}

Status RunCompletionCommand(const std::vector<std::string>& arguments,
                            CommandContext& context) {
  FREEGS_ASSIGN_OR_RETURN(const std::vector<std::string> positional,
                          CompletionWords().ParseAndApply(arguments));
  std::vector<CommandWords> all;
  for (const Command& command : context.commands) {
    all.push_back(command.words());
  }
  context.out << (positional[0] == "bash" ? BashCompletion(all)
                                          : ZshCompletion(all));
  return Status();
}

}  // namespace freegs::stages
