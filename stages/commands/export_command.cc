// SPDX-License-Identifier: BSD-3-Clause

#include "stages/commands/export_command.h"

#include <cctype>
#include <filesystem>

#include "core/files.h"
#include "pipeline/option_table.h"
#include "splat/ply_io.h"
#include "splat/splat_format.h"
#include "stages/scene_instances.h"
#include "stages/workspace_scene.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;

struct Format {
  std::string_view suffix;
  Status (*write)(const fs::path& path, const splat::GaussianModel& model);
};

constexpr Format kFormats[] = {{".ply", splat::WritePly},
                               {".splat", splat::WriteSplat}};

StatusOr<Format> FormatOf(const fs::path& path) {
  std::string suffix = path.extension().string();
  for (char& c : suffix) {
    c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  std::string known;
  for (const Format& format : kFormats) {
    if (suffix == format.suffix) return format;
    known += (known.empty() ? "" : ", ") + std::string(format.suffix);
  }
  return InvalidArgumentError(
      path.string() + ": the suffix says the format; known are " + known);
}

}  // namespace

Status RunExportCommand(const std::vector<std::string>& arguments,
                        CommandContext& context) {
  std::string out;
  std::string what = "color";
  pipeline::OptionTable table;
  table.Add("out", &out, {.help = "File to write; its suffix is the format."});
  table.Add("what",
            &what,
            {.help = "Which colours the Gaussians get.",
             .choices = {"color", "instances"}});
  FREEGS_ASSIGN_OR_RETURN(const pipeline::OptionTable::CommandLine line,
                          table.ParseCommandLine(arguments));
  FREEGS_RETURN_IF_ERROR(table.Apply(line.settings));
  if (line.positional.size() != 1) {
    return InvalidArgumentError(
        "export takes one workspace: export WORKSPACE --out FILE");
  }
  if (out.empty()) {
    return InvalidArgumentError("export needs a file to write: --out FILE");
  }
  const fs::path path(out);
  FREEGS_ASSIGN_OR_RETURN(const Format format, FormatOf(path));

  const fs::path workspace(line.positional[0]);
  FREEGS_ASSIGN_OR_RETURN(splat::GaussianModel model,
                          ReadWorkspaceModel(workspace));
  if (what == "instances") {
    FREEGS_ASSIGN_OR_RETURN(const std::vector<int32_t> labels,
                            ReadInstanceLabels(workspace, model.size()));
    model = ColorByInstance(model, labels);
  }
  if (path.has_parent_path()) {
    FREEGS_RETURN_IF_ERROR(CreateFolders(path.parent_path()));
  }
  FREEGS_RETURN_IF_ERROR(format.write(path, model));
  context.out << model.size() << " Gaussians in " << out << "\n";
  return Status();
}

}  // namespace freegs::stages
