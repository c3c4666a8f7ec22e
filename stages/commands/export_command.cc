// SPDX-License-Identifier: BSD-3-Clause

#include "stages/commands/export_command.h"

#include <cctype>
#include <charconv>
#include <filesystem>
#include <system_error>

#include "core/io/files.h"
#include "core/number_text.h"
#include "splat/scene/ply_io.h"
#include "splat/scene/splat_format.h"
#include "stages/scene/scene_instances.h"
#include "stages/scene/workspace_scene.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;

// The format cannot say where the model lies in the world.
Status WriteSplat(const fs::path& path,
                  const splat::GaussianModel& model,
                  const Eigen::Vector3d& /*offset*/) {
  return splat::WriteSplat(path, model);
}

struct Format {
  std::string_view suffix;
  Status (*write)(const fs::path& path,
                  const splat::GaussianModel& model,
                  const Eigen::Vector3d& offset);
};

constexpr Format kFormats[] = {{".ply", splat::WritePly},
                               {".splat", WriteSplat}};

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

// Parses a list of instance ids such as "3,17".
StatusOr<std::vector<int>> ParseIds(const std::string& option,
                                    const std::string& text) {
  std::vector<int> ids;
  const char* at = text.data();
  const char* const end = at + text.size();
  while (true) {
    int id = 0;
    const auto [stop, error] = std::from_chars(at, end, id);
    if (error != std::errc() || (stop != end && *stop != ',')) {
      return InvalidArgumentError("--" + option + ": \"" + text +
                                  "\" is no list of instance ids like 3,17");
    }
    ids.push_back(id);
    if (stop == end) return ids;
    at = stop + 1;
  }
}

struct ExportRequest {
  std::string out;
  std::string what = "color";
  std::string only;
  std::string without;
};

// The Gaussians that the request asks for, in the colours it asks for.
Status Prepare(const ExportRequest& request,
               const fs::path& workspace,
               splat::GaussianModel* model) {
  const bool some = !request.only.empty() || !request.without.empty();
  if (!some && request.what != "instances") return Status();
  FREEGS_ASSIGN_OR_RETURN(const std::vector<int32_t> labels,
                          ReadInstanceLabels(workspace, model->size()));
  if (request.what == "instances") *model = ColorByInstance(*model, labels);
  if (!some) return Status();
  const bool without = request.only.empty();
  const std::string option = without ? "without" : "only";
  FREEGS_ASSIGN_OR_RETURN(
      const std::vector<int> ids,
      ParseIds(option, without ? request.without : request.only));
  StatusOr<splat::GaussianModel> selected =
      SelectInstances(*model, labels, ids, without);
  if (!selected.ok()) return selected.status().Annotated("--" + option);
  *model = *std::move(selected);
  return Status();
}

CommandWords DescribeExport(ExportRequest* request) {
  CommandWords words("export",
                     "Writes the scene to one file for other programs.");
  words.AddArgument(WorkspaceArgument());
  words.AddOption("out",
                  &request->out,
                  {.help = "File to write; its suffix is the format (.ply, "
                           ".splat).",
                   .value_name = "FILE"});
  words.AddOption("what",
                  &request->what,
                  {.help = "Which colours the Gaussians get.",
                   .choices = {"color", "instances"}});
  words.AddOption("only",
                  &request->only,
                  {.help = "Ids of the instances to write, like 3,17.",
                   .value_name = "ID,..."});
  words.AddOption(
      "without",
      &request->without,
      {.help = "Ids of the instances to leave out.", .value_name = "ID,..."});
  words.Require("out");
  return words;
}

}  // namespace

CommandWords ExportWords() { return KeepWords<ExportRequest>(DescribeExport); }

Status RunExportCommand(const std::vector<std::string>& arguments,
                        CommandContext& context) {
  ExportRequest request;
  CommandWords words = DescribeExport(&request);
  FREEGS_ASSIGN_OR_RETURN(const std::vector<std::string> positional,
                          words.ParseAndApply(arguments));
  if (!request.only.empty() && !request.without.empty()) {
    return InvalidArgumentError("--only and --without exclude each other");
  }
  const fs::path path(request.out);
  FREEGS_ASSIGN_OR_RETURN(const Format format, FormatOf(path));
  FREEGS_RETURN_IF_ERROR(PrepareOutputFile(path));

  const fs::path workspace(positional[0]);
  WarnOfRun(workspace, context);
  FREEGS_ASSIGN_OR_RETURN(splat::PlacedModel world,
                          ReadWorkspaceModel(workspace));
  splat::GaussianModel& model = world.model;
  FREEGS_RETURN_IF_ERROR(Prepare(request, workspace, &model));
  FREEGS_RETURN_IF_ERROR(format.write(path, model, world.offset));
  context.out << model.size() << " Gaussians in " << request.out << "\n";
  if (!world.offset.isZero(0)) {
    context.out << "its positions count from "
                << FormatSignificant(world.offset.x(), 17) << " "
                << FormatSignificant(world.offset.y(), 17) << " "
                << FormatSignificant(world.offset.z(), 17)
                << ", since float32 numbers of the world would be too coarse\n";
  }
  return Status();
}

}  // namespace freegs::stages
