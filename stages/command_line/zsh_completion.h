// SPDX-License-Identifier: BSD-3-Clause
// The script that completes words of the program in zsh. It does not need the
// program itself. Either of these makes zsh use it:
//
//   source <(freegs_pipeline completion zsh)
//   freegs_pipeline completion zsh > FOLDER_OF_FPATH/_freegs_pipeline

#ifndef FREEGS_STAGES_COMMAND_LINE_ZSH_COMPLETION_H_
#define FREEGS_STAGES_COMMAND_LINE_ZSH_COMPLETION_H_

#include <string>
#include <vector>

#include "stages/command_line/command_words.h"

namespace freegs::stages {

// The text of the script. Beside what bash gets, zsh shows the first sentence
// of the help of each option.
std::string ZshCompletion(const std::vector<CommandWords>& commands);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_COMMAND_LINE_ZSH_COMPLETION_H_
