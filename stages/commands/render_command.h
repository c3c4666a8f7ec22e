// SPDX-License-Identifier: BSD-3-Clause
// `render WORKSPACE --out DIR`: renders the scene from any camera, as pictures
// or as a film.

#ifndef FREEGS_STAGES_COMMANDS_RENDER_COMMAND_H_
#define FREEGS_STAGES_COMMANDS_RENDER_COMMAND_H_

#include <string>
#include <vector>

#include "core/status.h"
#include "stages/commands/command.h"

namespace freegs::stages {

CommandWords RenderWords();

// Renders the views of the photos at the size of training, or those of
// --cameras FILE at their own size, into DIR/NAME.png. --what chooses the
// picture:
//   color      8-bit RGB
//   depth      16-bit, z in the camera frame; DIR/depth.json holds the world
//              units per step, and 0 means that nothing is there
//   instances  16-bit, instance id, 0 for none
//   semantics  8-bit RGB, the first principal axes of the semantic vectors
// Depth and instances also get colour pictures in DIR/preview/.
// FILE is a camera file (stages/scene/camera_file.h). Its poses may be in
// another world frame: they are aligned by the poses of the photos that the
// file and the workspace both name, unless --no-align is given.
//
// --path moves the camera along a way (stages/film/film_views.h): orbit,
// photos, or through the poses of a camera file. It takes --seconds and gives
// --fps pictures per second. --video FILE.mp4 makes a film of them, in the
// colours of the previews, and of "both": colour and instances side by side.
//
// --only 3,17 shows only these instances, and an orbit then circles them;
// --without 3,17 leaves them out.
Status RunRenderCommand(const std::vector<std::string>& arguments,
                        CommandContext& context);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_COMMANDS_RENDER_COMMAND_H_
