// SPDX-License-Identifier: BSD-3-Clause

#include "stages/commands/render_request.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "pipeline/option_table.h"
#include "stages/command_line/command_words.h"

namespace freegs::stages {
namespace {

// `given` has the names of the options on the command line.
Status CheckRenderWords(const RenderRequest& request,
                        const std::set<std::string>& given) {
  if (request.path.empty()) {
    for (const char* name : {"video", "seconds", "fps"}) {
      if (!given.contains(name)) continue;
      return InvalidArgumentError(
          "--" + std::string(name) +
          " needs a way for the camera: --path orbit, photos or a camera file");
    }
  } else if (!request.cameras.empty()) {
    return InvalidArgumentError(
        "--cameras and --path exclude each other; --path takes a camera file, "
        "too");
  }
  if (request.what == "both" && request.video.empty()) {
    return InvalidArgumentError("--what both is for --video only");
  }
  if (request.has_granularity && request.what != "instances" &&
      request.what != "both") {
    return InvalidArgumentError("--granularity is for --what instances only");
  }
  const bool file = !request.cameras.empty() ||
                    (!request.path.empty() && request.path != "orbit" &&
                     request.path != "photos");
  if (request.no_align && !file) {
    return InvalidArgumentError("--no-align is for camera files only");
  }
  return CheckInstanceChoice(request.choice);
}

}  // namespace

int RenderRequest::num_frames() const {
  return std::max(1, static_cast<int>(std::lround(seconds * fps)));
}

CommandWords DescribeRender(RenderRequest* request) {
  CommandWords words(
      "render",
      "Renders the scene from the cameras of its photos, or from any others.");
  words.AddArgument(WorkspaceArgument());
  words.AddOption("out",
                  &request->out,
                  {.help = "Folder for the pictures.", .value_name = "DIR"});
  words.AddOption(
      "video",
      &request->video,
      {.help = "A film to write in place of pictures, FILE.mp4; needs "
               "--path.",
       .value_name = "FILE"});
  words.AddOption(
      "path",
      &request->path,
      {.help = "The way of the camera: orbit circles the scene, or the "
               "object that --only names; photos goes smoothly through "
               "the photos' poses, in the order of their names; FILE "
               "goes through those of a camera file (its \"test\" "
               "section if it has one).",
       .value_name = "orbit|photos|FILE"});
  words.AddOption("seconds",
                  &request->seconds,
                  {.help = "How long the way takes.", .min = 0.1, .max = 3600});
  words.AddOption(
      "fps",
      &request->fps,
      {.help = "Pictures per second of the way.", .min = 1, .max = 240});
  words.AddOption(
      "cameras",
      &request->cameras,
      {.help = "JSON file of cameras; without it, those of the photos.",
       .value_name = "FILE"});
  words.AddOption(
      "what",
      &request->what,
      {.help = "What to render; both shows colour and instances side by "
               "side in a film.",
       .choices = {"color", "depth", "instances", "semantics", "both"}});
  words.AddOption(
      "only",
      &request->choice.only,
      {.help = "Ids of the instances to show, like 3,17, without all "
               "else.",
       .value_name = "ID,..."});
  words.AddOption(
      "without",
      &request->choice.without,
      {.help = "Ids of the instances to leave out.", .value_name = "ID,..."});
  words.AddOption(
      "granularity",
      &request->granularity,
      {.help = "With --what instances: instances of another granularity "
               "than bootstrap.granularity, without running the stage "
               "again.",
       .min = -100,
       .max = 100});
  words.AddOption(
      "size",
      &request->size,
      {.help = "Longest side in pixels at most; 0 is the size of training "
               "or of the camera file.",
       .min = 0});
  words.AddThreads(&request->threads);
  words.AddOption("no-align",
                  &request->no_align,
                  {.help = "The cameras are in the scene's own world frame."});
  words.RequireOneOf({"out", "video"});
  return words;
}

StatusOr<RenderRequest> ParseRenderRequest(
    const std::vector<std::string>& arguments) {
  RenderRequest request;
  CommandWords words = DescribeRender(&request);
  FREEGS_ASSIGN_OR_RETURN(const pipeline::OptionTable::CommandLine line,
                          words.Parse(arguments));
  FREEGS_RETURN_IF_ERROR(words.table().Apply(line.settings));
  std::set<std::string> given;
  for (const pipeline::OptionSetting& setting : line.settings) {
    given.insert(setting.name);
  }
  request.has_granularity = given.contains("granularity");
  FREEGS_RETURN_IF_ERROR(CheckRenderWords(request, given));
  FREEGS_ASSIGN_OR_RETURN(request.workspace,
                          ExistingWorkspace(line.positional[0]));
  return request;
}

}  // namespace freegs::stages
