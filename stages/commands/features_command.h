// SPDX-License-Identifier: BSD-3-Clause
// `features IMAGE --text WORDS --model DIR --out FILE`: what CLIP sees where.

#ifndef FREEGS_STAGES_COMMANDS_FEATURES_COMMAND_H_
#define FREEGS_STAGES_COMMANDS_FEATURES_COMMAND_H_

#include <string>
#include <vector>

#include "core/status.h"
#include "stages/commands/command.h"

namespace freegs::stages {

// Writes a picture of the image, upright, in grey, with the places that are
// like the words in colour: dense features of the model, upsampled along the
// image's edges, and their relevancy to the words against the model's canonical
// phrases as in LERF. Relevancy up to one half has no colour: the place is no
// more like the words than like one of these. Prints the range of the
// relevancy and where it is highest, in pixels of the picture.
// --cache DIR keeps the features for other words.
Status RunFeaturesCommand(const std::vector<std::string>& arguments,
                          CommandContext& context);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_COMMANDS_FEATURES_COMMAND_H_
