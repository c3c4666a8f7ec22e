// SPDX-License-Identifier: BSD-3-Clause

#include "stages/commands/init_command.h"

#include <filesystem>
#include <system_error>

#include "core/io/files.h"
#include "pipeline/workspace.h"
#include "stages/commands/workspace_readme.h"
#include "stages/registry/pipeline_options.h"
#include "stages/run/workspace_folder.h"

namespace freegs::stages {

namespace fs = std::filesystem;

std::string ConfigTemplate() {
  PipelineOptions options;
  return MakeOptionTable(&options).ConfigTemplate();
}

std::string WorkspaceReadme() { return kWorkspaceReadme; }

CommandWords InitWords() {
  CommandWords words("init",
                     "Writes a config.ini that explains every option, and a "
                     "README. Files that are there stay as they are.");
  words.AddArgument({.name = "WORKSPACE",
                     .help = "The folder to write to; it is made if it is not "
                             "there."});
  return words;
}

Status RunInitCommand(const std::vector<std::string>& arguments,
                      CommandContext& context) {
  FREEGS_ASSIGN_OR_RETURN(const std::vector<std::string> positional,
                          InitWords().ParseAndApply(arguments));
  const fs::path workspace = positional[0];
  // The photos may be there before the workspace is. Command init is not told
  // where, so it goes by these names.
  FREEGS_RETURN_IF_ERROR(CheckWorkspaceFolder(
      workspace, {workspace / "photos", workspace / "images"}));
  FREEGS_RETURN_IF_ERROR(PrepareOutputFolder(workspace));
  const std::pair<fs::path, std::string> files[] = {
      {pipeline::ConfigPath(workspace), ConfigTemplate()},
      {workspace / "README.md", WorkspaceReadme()},
  };
  for (const auto& [path, text] : files) {
    if (IsNameTaken(path)) {
      context.out << path.string() << ": is there already, left as it is\n";
      continue;
    }
    FREEGS_RETURN_IF_ERROR(WriteFileAtomic(path, text));
    context.out << path.string() << ": written\n";
  }
  return Status();
}

}  // namespace freegs::stages
