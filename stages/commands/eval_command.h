// SPDX-License-Identifier: BSD-3-Clause
// `eval WORKSPACE [--gt DIR [--layout NAME]] [--model DIR] [--text-threshold R]
// [--json FILE]`.

#ifndef FREEGS_STAGES_COMMANDS_EVAL_COMMAND_H_
#define FREEGS_STAGES_COMMANDS_EVAL_COMMAND_H_

#include <string>
#include <vector>

#include "core/status.h"
#include "stages/commands/command.h"

namespace freegs::stages {

// Measures the workspace's scene: on its holdout photographs, and with --gt
// against the truth in DIR (see datasets/layout.h). Prints a table, and writes
// the figures to FILE as JSON ("-" is standard output instead of the table).
Status RunEvalCommand(const std::vector<std::string>& arguments,
                      CommandContext& context);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_COMMANDS_EVAL_COMMAND_H_
