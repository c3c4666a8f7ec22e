// SPDX-License-Identifier: BSD-3-Clause
// `view WORKSPACE`: a web page of the scene, and of a run under way.

#ifndef FREEGS_STAGES_COMMANDS_VIEW_COMMAND_H_
#define FREEGS_STAGES_COMMANDS_VIEW_COMMAND_H_

#include <string>
#include <vector>

#include "core/status.h"
#include "stages/commands/command.h"

namespace freegs::stages {

CommandWords ViewWords();

// Serves the workspace until the command is cancelled, which is its normal end
// and no error. Prints "view: ADDRESS" once it listens.
//   --port N         the port; without it 8717 or the next that is free
//   --host ADDRESS   where to listen, 127.0.0.1 by default; elsewhere than at
//                    this machine's own address the printed one has a token
//   --open           shows the page in the browser of the desktop
// See docs/view.md.
//
// kBadInput when there is no such workspace or no port.
Status RunViewCommand(const std::vector<std::string>& arguments,
                      CommandContext& context);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_COMMANDS_VIEW_COMMAND_H_
