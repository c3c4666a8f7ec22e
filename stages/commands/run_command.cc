// SPDX-License-Identifier: BSD-3-Clause

#include "stages/commands/run_command.h"

#include <filesystem>
#include <iostream>
#include <system_error>
#include <unistd.h>
#include <utility>

#include "core/io/files.h"
#include "photos/photo_scan.h"
#include "pipeline/logger.h"
#include "pipeline/stage_record.h"
#include "pipeline/stage_runner.h"
#include "pipeline/version.h"
#include "pipeline/workspace.h"
#include "stages/registry/pipeline_options.h"
#include "stages/registry/stage_registry.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;
using pipeline::OptionSetting;
using pipeline::OptionTable;
using pipeline::WorkspaceInfo;

fs::path Absolute(const std::string& path) {
  std::error_code error;
  fs::path absolute = fs::absolute(path, error).lexically_normal();
  // "photos/" and "photos" shall be the same path.
  if (!absolute.has_filename()) absolute = absolute.parent_path();
  return absolute;
}

// Whether `inner` is `outer` or lies below it, after links are resolved.
bool IsWithin(const fs::path& inner, const fs::path& outer) {
  std::error_code error;
  const fs::path relative =
      fs::weakly_canonical(inner, error)
          .lexically_relative(fs::weakly_canonical(outer, error));
  return !relative.empty() && *relative.begin() != "..";
}

// A mistyped argument must not fill a folder of other files with stages.
Status CheckWorkspaceFolder(const fs::path& workspace) {
  std::error_code error;
  if (!fs::exists(workspace, error)) return Status();
  if (!fs::is_directory(workspace, error)) {
    return BadInputError(workspace.string() + ": not a folder");
  }
  bool empty = true;
  for (const fs::directory_entry& entry :
       fs::directory_iterator(workspace, error)) {
    const std::string name = entry.path().filename().string();
    // The latter is left when the first run ends before it has begun.
    empty = empty && (name.starts_with('.') || name == "workspace.json.part");
    for (const char* known : {"workspace.json",
                              "config.ini",
                              "ingest",
                              "sfm",
                              "undistort",
                              "reconstruct"}) {
      if (name == known) return Status();
    }
  }
  if (error) {
    return BadInputError(workspace.string() +
                         ": cannot read: " + error.message());
  }
  if (empty) return Status();
  return BadInputError(workspace.string() +
                       ": holds other files and is not a workspace; give a "
                       "new or empty folder (the order is IMAGES WORKSPACE)");
}

Status CheckImagesFolder(const fs::path& images, const fs::path& workspace) {
  std::error_code error;
  if (fs::is_directory(images, error)) {
    if (IsWithin(workspace, images)) {
      return InvalidArgumentError(
          workspace.string() +
          ": the workspace lies inside the photo folder; its own pictures "
          "would be taken for photos. Give a folder outside " +
          images.string());
    }
    return Status();
  }
  if (fs::is_regular_file(images, error) && photos::HasFilmExtension(images)) {
    return Status();
  }
  // Once stage ingest has read the photos, they are no longer needed.
  if (pipeline::ReadStageRecord(pipeline::StageFolder(workspace, "ingest"))
          .ok()) {
    return Status();
  }
  return BadInputError(
      images.string() +
      (fs::exists(images, error)
           ? ": not a folder and not a film; give the folder of "
             "the photos, or a film such as a.mp4"
           : ": no such folder of photos"));
}

// What the command line asks for.
struct Request {
  fs::path workspace;
  WorkspaceInfo info;
  std::string from;
  std::string to;
  std::string forced;
};

Status Execute(const Request& request,
               const PipelineOptions& options,
               const OptionTable& table,
               CommandContext& context) {
  const bool terminal =
      &context.err == &std::cerr && isatty(STDERR_FILENO) != 0;
  pipeline::Logger logger(
      context.err, terminal, pipeline::LogPath(request.workspace));
  logger.LogToFile(
      pipeline::LogLevel::kInfo,
      std::string("freegs_pipeline ") + pipeline::kProgramVersion + " begins");
  if (options.general.verbose) {
    for (const OptionTable::Option& option : table.options()) {
      if (option.section().empty()) continue;
      logger.Log(pipeline::LogLevel::kInfo,
                 "option " + option.name + " = " + option.value());
    }
  }
  pipeline::StageRunnerOptions runner_options;
  runner_options.workspace = request.workspace;
  runner_options.images = request.info.images;
  runner_options.from = request.from;
  runner_options.to = request.to;
  runner_options.forced = request.forced;
  runner_options.num_threads = options.general.threads;
  runner_options.checkpoint_interval_seconds =
      options.general.checkpoint_interval;
  pipeline::StageRunner runner(MakeStages(options, table),
                               std::move(runner_options),
                               context.cancellation,
                               logger);
  return runner.Run();
}

// Notes the options of the command line for workspace.json. Paths are stored as
// DisplayPath writes them.
void Remember(const fs::path& workspace,
              const OptionTable& table,
              const std::vector<OptionSetting>& settings,
              WorkspaceInfo* info) {
  for (const OptionSetting& setting : settings) {
    const OptionTable::Option* option = table.Find(setting.name);
    if (option->section().empty()) continue;
    info->settings[setting.name] =
        option->spec.is_path && !setting.value.empty()
            ? pipeline::DisplayPath(workspace, setting.value)
            : setting.value;
  }
}

}  // namespace

Status RunRunCommand(const std::vector<std::string>& arguments,
                     CommandContext& context) {
  PipelineOptions options;
  OptionTable table = MakeOptionTable(&options);
  Request request;
  table.Add("from",
            &request.from,
            {.help = "First stage to bring up to date; earlier ones are used "
                     "as they are."});
  table.Add("to", &request.to, {.help = "Last stage to bring up to date."});
  FREEGS_ASSIGN_OR_RETURN(const OptionTable::CommandLine line,
                          table.ParseCommandLine(arguments));
  const std::vector<std::string>& words = line.positional;
  if (words.empty() || words.size() > 2) {
    return InvalidArgumentError(
        "run takes a folder of photos (or a film) and a workspace folder: run "
        "IMAGES "
        "WORKSPACE");
  }
  request.workspace = Absolute(words.back());
  FREEGS_RETURN_IF_ERROR(CheckWorkspaceFolder(request.workspace));
  FREEGS_ASSIGN_OR_RETURN(request.info,
                          pipeline::ReadWorkspaceInfo(request.workspace));
  if (words.size() == 2) request.info.images = Absolute(words.front());
  if (request.info.images.empty()) {
    return InvalidArgumentError(
        request.workspace.string() +
        ": does not know its photos yet; give both: run IMAGES WORKSPACE");
  }
  FREEGS_RETURN_IF_ERROR(
      CheckImagesFolder(request.info.images, request.workspace));
  FREEGS_RETURN_IF_ERROR(
      ApplySettings(request.workspace, line.settings, table));
  FREEGS_RETURN_IF_ERROR(PrepareOutputFolder(request.workspace));
  FREEGS_ASSIGN_OR_RETURN(const pipeline::WorkspaceLock lock,
                          pipeline::WorkspaceLock::Acquire(request.workspace));
  request.info.settings.clear();
  Remember(request.workspace, table, line.settings, &request.info);
  FREEGS_RETURN_IF_ERROR(
      pipeline::WriteWorkspaceInfo(request.workspace, request.info));
  return Execute(request, options, table, context);
}

Status RunStageCommand(const std::vector<std::string>& arguments,
                       CommandContext& context) {
  PipelineOptions options;
  OptionTable table = MakeOptionTable(&options);
  FREEGS_ASSIGN_OR_RETURN(const OptionTable::CommandLine line,
                          table.ParseCommandLine(arguments));
  if (line.positional.size() != 2) {
    return InvalidArgumentError(
        "stage takes the name of a stage and a workspace: stage STAGE "
        "WORKSPACE");
  }
  Request request;
  request.forced = line.positional[0];
  request.from = request.forced;
  request.to = request.forced;
  request.workspace = Absolute(line.positional[1]);
  std::error_code error;
  if (!fs::is_directory(request.workspace, error)) {
    return BadInputError(request.workspace.string() + ": no such workspace");
  }
  FREEGS_ASSIGN_OR_RETURN(const pipeline::WorkspaceLock lock,
                          pipeline::WorkspaceLock::Acquire(request.workspace));
  FREEGS_ASSIGN_OR_RETURN(request.info,
                          pipeline::ReadWorkspaceInfo(request.workspace));
  Remember(request.workspace, table, line.settings, &request.info);
  FREEGS_RETURN_IF_ERROR(
      ApplySettings(request.workspace,
                    RememberedSettings(request.workspace, request.info, table),
                    table));
  FREEGS_RETURN_IF_ERROR(
      pipeline::WriteWorkspaceInfo(request.workspace, request.info));
  return Execute(request, options, table, context);
}

}  // namespace freegs::stages
