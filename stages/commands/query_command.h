// SPDX-License-Identifier: BSD-3-Clause
// `query WORKSPACE --text WORDS`: finds the instance that is meant, in space
// and in every view.

#ifndef FREEGS_STAGES_COMMANDS_QUERY_COMMAND_H_
#define FREEGS_STAGES_COMMANDS_QUERY_COMMAND_H_

#include <string>
#include <vector>

#include "core/status.h"
#include "stages/commands/command.h"

namespace freegs::stages {

// One of these asks the question:
//   --text WORDS             the instances most relevant to the words
//   --example IMAGE          the instances most like the picture
//   --click VIEW X Y         the instance at a pixel of a view
//   --box VIEW X0 Y0 X1 Y1   the instance that the box is drawn around
// Prints a table, or with --json the answer as JSON. With --out DIR also writes
// DIR/query.json, DIR/masks/VIEW.png and DIR/overlay/VIEW.jpg for the views of
// the photos or of --cameras FILE. Finding nothing is an answer, not an error.
// See docs/queries.md.
//
// kBadInput when a stage has not been run or the scene has no semantics;
// kMissingDependency when the CLIP model is missing or is not the one that the
// scene's features were made with; kInvalidArgument for an unknown view and for
// a pixel outside the view.
Status RunQueryCommand(const std::vector<std::string>& arguments,
                       CommandContext& context);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_COMMANDS_QUERY_COMMAND_H_
