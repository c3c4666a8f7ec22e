// SPDX-License-Identifier: BSD-3-Clause
// `eval WORKSPACE [--gt DIR [--layout NAME]] [--model DIR]
//       [--text-from instances|gaussians] [--text-threshold R] [--json FILE]`:
// measures a scene.

#ifndef FREEGS_STAGES_COMMANDS_EVAL_COMMAND_H_
#define FREEGS_STAGES_COMMANDS_EVAL_COMMAND_H_

#include <string>
#include <vector>

#include "core/status.h"
#include "stages/commands/command.h"

namespace freegs::stages {

CommandWords EvalWords();

// Measures the workspace's scene on its holdout photographs, and with --gt
// against the truth in DIR (stages/datasets/layout.h). Prints a table and
// writes the figures as JSON to FILE; with FILE "-" the JSON goes to standard
// output and there is no table.
Status RunEvalCommand(const std::vector<std::string>& arguments,
                      CommandContext& context);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_COMMANDS_EVAL_COMMAND_H_
