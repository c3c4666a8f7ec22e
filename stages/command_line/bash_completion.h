// SPDX-License-Identifier: BSD-3-Clause
// The script that completes words of the program in bash. It needs neither the
// package bash-completion nor the program itself:
//
//   source <(freegs_pipeline completion bash)

#ifndef FREEGS_STAGES_COMMAND_LINE_BASH_COMPLETION_H_
#define FREEGS_STAGES_COMMAND_LINE_BASH_COMPLETION_H_

#include <string>
#include <vector>

#include "stages/command_line/command_words.h"

namespace freegs::stages {

// The text of the script. It completes commands, their options, and values:
// choices, files and folders.
std::string BashCompletion(const std::vector<CommandWords>& commands);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_COMMAND_LINE_BASH_COMPLETION_H_
