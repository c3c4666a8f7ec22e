// SPDX-License-Identifier: BSD-3-Clause
// `features IMAGE --text WORDS [--model DIR] [--out FILE]`: draws where in an
// image CLIP sees the words.

#ifndef FREEGS_STAGES_COMMANDS_FEATURES_COMMAND_H_
#define FREEGS_STAGES_COMMANDS_FEATURES_COMMAND_H_

#include <string>
#include <vector>

#include "core/status.h"
#include "stages/commands/command.h"

namespace freegs::stages {

CommandWords FeaturesWords();

// Writes the upright image in grey, with the places that are like the words in
// colour. The model's dense features are upsampled along the edges of the
// image, by the model's upsampler.onnx if it has one and by joint bilateral
// upsampling otherwise. Their relevancy to the words is that of LERF, against
// the model's canonical phrases. Relevancy up to 0.5 has no colour: the place
// is at least as much like a canonical phrase as like the words. Prints the
// range of the relevancy and where it is highest, in pixels of the picture.
// --cache DIR keeps the features for other words.
Status RunFeaturesCommand(const std::vector<std::string>& arguments,
                          CommandContext& context);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_COMMANDS_FEATURES_COMMAND_H_
