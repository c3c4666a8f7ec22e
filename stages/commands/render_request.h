// SPDX-License-Identifier: BSD-3-Clause
// What `render` is asked for on its command line.

#ifndef FREEGS_STAGES_COMMANDS_RENDER_REQUEST_H_
#define FREEGS_STAGES_COMMANDS_RENDER_REQUEST_H_

#include <filesystem>
#include <string>
#include <vector>

#include "core/status.h"
#include "stages/command_line/command_words.h"
#include "stages/commands/instance_choice.h"

namespace freegs::stages {

struct RenderRequest {
  std::filesystem::path workspace;
  std::string out;      // Folder for pictures.
  std::string video;    // A film.
  std::string cameras;  // A camera file.
  std::string path;     // "orbit", "photos" or a camera file.
  std::string what = "color";
  double granularity = 0;  // That of instances, where it is given.
  bool has_granularity = false;
  InstanceChoice choice;
  double seconds = 10;
  double fps = 30;
  int size = 0;
  int threads = 0;
  bool no_align = false;

  int num_frames() const;
};

// The words of the command; they set the request.
CommandWords DescribeRender(RenderRequest* request);

// Returns kInvalidArgument for words that do not fit each other, before
// anything is read or written. Returns kBadInput when there is no workspace.
StatusOr<RenderRequest> ParseRenderRequest(
    const std::vector<std::string>& arguments);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_COMMANDS_RENDER_REQUEST_H_
