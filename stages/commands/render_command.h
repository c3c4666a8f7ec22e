// SPDX-License-Identifier: BSD-3-Clause
// `render WORKSPACE --out DIR`: pictures of the scene from any camera.

#ifndef FREEGS_STAGES_COMMANDS_RENDER_COMMAND_H_
#define FREEGS_STAGES_COMMANDS_RENDER_COMMAND_H_

#include <string>
#include <vector>

#include "core/status.h"
#include "stages/commands/command.h"

namespace freegs::stages {

// Renders the views of undistort/sparse at the size training used, or those of
// --cameras FILE at their own size, into DIR/NAME.png:
//   color      8-bit RGB;
//   depth      16-bit, z in the camera frame; DIR/depth.json says how many
//   world
//              units one step is; 0 is nothing; DIR/preview/ has colour
//              pictures;
//   instances  16-bit, instance id, 0 is none; DIR/preview/ likewise;
//   semantics  8-bit RGB, the first principal axes of the semantic vectors.
// FILE (cameras.json, see stages/evaluation/ground_truth.h) may be in another
// world frame: it is aligned by the similarity between the poses of the photos
// that both name, unless --no-align is given.
Status RunRenderCommand(const std::vector<std::string>& arguments,
                        CommandContext& context);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_COMMANDS_RENDER_COMMAND_H_
