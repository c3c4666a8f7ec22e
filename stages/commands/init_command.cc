// SPDX-License-Identifier: BSD-3-Clause

#include "stages/commands/init_command.h"

#include <filesystem>
#include <system_error>

#include "core/io/files.h"
#include "pipeline/workspace.h"
#include "stages/commands/workspace_readme.h"
#include "stages/registry/pipeline_options.h"

namespace freegs::stages {

namespace fs = std::filesystem;

std::string ConfigTemplate() {
  PipelineOptions options;
  return MakeOptionTable(&options).ConfigTemplate();
}

std::string WorkspaceReadme() { return kWorkspaceReadme; }

Status RunInitCommand(const std::vector<std::string>& arguments,
                      CommandContext& context) {
  if (arguments.size() != 1 || arguments[0].empty() ||
      arguments[0].starts_with("--")) {
    return InvalidArgumentError("init takes one folder: init WORKSPACE");
  }
  const fs::path workspace = arguments[0];
  std::error_code error;
  if (fs::exists(workspace, error) && !fs::is_directory(workspace, error)) {
    return BadInputError(workspace.string() + ": not a folder");
  }
  FREEGS_RETURN_IF_ERROR(PrepareOutputFolder(workspace));
  const std::pair<fs::path, std::string> files[] = {
      {pipeline::ConfigPath(workspace), ConfigTemplate()},
      {workspace / "README.md", WorkspaceReadme()},
  };
  for (const auto& [path, text] : files) {
    if (fs::exists(path, error)) {
      context.out << path.string() << ": is there already, left as it is\n";
      continue;
    }
    FREEGS_RETURN_IF_ERROR(WriteFileAtomic(path, text));
    context.out << path.string() << ": written\n";
  }
  return Status();
}

}  // namespace freegs::stages
