// SPDX-License-Identifier: BSD-3-Clause
// `model FILE.safetensors|FOLDER --out DIR [--merges FILE] [--dense-size N]`:
// makes a model folder of a CLIP's weights.

#ifndef FREEGS_STAGES_COMMANDS_MODEL_COMMAND_H_
#define FREEGS_STAGES_COMMANDS_MODEL_COMMAND_H_

#include <string>
#include <vector>

#include "core/status.h"
#include "stages/commands/command.h"

namespace freegs::stages {

CommandWords ModelWords();

// Reads weights in the layout of Hugging Face or of OpenCLIP and writes the
// folder that --bootstrap.model and --model take. See
// semantics/clip_export/clip_export.h for what is read, and for errors.
Status RunModelCommand(const std::vector<std::string>& arguments,
                       CommandContext& context);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_COMMANDS_MODEL_COMMAND_H_
