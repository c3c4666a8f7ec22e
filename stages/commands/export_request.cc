// SPDX-License-Identifier: BSD-3-Clause

#include "stages/commands/export_request.h"

#include <algorithm>
#include <iterator>

#include "core/io/files.h"
#include "pipeline/option_table.h"
#include "stages/command_line/command_words.h"

namespace freegs::stages {
namespace {

bool WritesGaussians(const ExportRequest& request) {
  return request.what == "color" || request.what == "instances";
}

Status CheckSuffix(const ExportRequest& request) {
  const std::string suffix = LowerSuffix(request.out);
  if (request.what == "masks" || request.what == "boxes") {
    if (suffix == ".json") return Status();
    return InvalidArgumentError(request.out + ": --what " + request.what +
                                " writes a .json file");
  }
  std::string list;
  for (const std::string_view known : kGaussianSuffixes) {
    if (suffix == known) return Status();
    list += (list.empty() ? "" : ", ") + std::string(known);
  }
  if (suffix == ".json") {
    return InvalidArgumentError(
        request.out +
        ": a .json file needs --what masks or --what boxes to be written");
  }
  return InvalidArgumentError(
      request.out + ": the suffix says the format; known are " + list);
}

// A folder with the name of a file would be in the way of that file.
Status CheckFolderName(const std::string& folder) {
  const std::string suffix = LowerSuffix(folder);
  constexpr std::string_view kOthers[] = {".json", ".glb", ".txt", ".bin"};
  if (std::ranges::find(kGaussianSuffixes, suffix) != kGaussianSuffixes.end() ||
      std::ranges::find(kOthers, suffix) != std::end(kOthers)) {
    return InvalidArgumentError(folder +
                                ": the name of a file, but a folder is "
                                "written; give another name");
  }
  return Status();
}

Status CheckWords(const ExportRequest& request, bool format_given) {
  if (!request.objects.empty()) {
    if (!WritesGaussians(request)) {
      return InvalidArgumentError(
          "--objects writes Gaussians: --what color or instances");
    }
    return CheckFolderName(request.objects);
  }
  if (format_given) {
    return InvalidArgumentError(
        "--format is for --objects DIR only; of --out FILE the suffix says "
        "the format");
  }
  if (request.what == "colmap") {
    if (request.choice.everything()) return CheckFolderName(request.out);
    return InvalidArgumentError(
        "--only and --without are not for --what colmap, which has no "
        "instances");
  }
  return CheckSuffix(request);
}

}  // namespace

CommandWords DescribeExport(ExportRequest* request) {
  CommandWords words("export",
                     "Writes the scene, its objects, masks, boxes or cameras "
                     "for other programs.");
  words.AddArgument(WorkspaceArgument());
  words.AddOption(
      "out",
      &request->out,
      {.help = "File to write; its suffix is the format. With --what "
               "colmap a folder.",
       .value_name = "FILE"});
  words.AddOption(
      "what",
      &request->what,
      {.help = "What to write: the Gaussians in their own colours or in "
               "those of their instances (.ply, .splat, .spz); the "
               "instances' masks in all photos, as COCO's JSON; their "
               "boxes (.json); the cameras and points, as COLMAP's text "
               "model.",
       .choices = {"color", "instances", "masks", "boxes", "colmap"}});
  words.AddOption("only",
                  &request->choice.only,
                  {.help = "Ids of the instances to write, like 3,17.",
                   .value_name = "ID,..."});
  words.AddOption(
      "without",
      &request->choice.without,
      {.help = "Ids of the instances to leave out.", .value_name = "ID,..."});
  words.AddOption("objects",
                  &request->objects,
                  {.help = "In place of --out: a folder that gets one file of "
                           "Gaussians for each instance, ID.ply.",
                   .value_name = "DIR"});
  words.AddOption("format",
                  &request->format,
                  {.help = "Format of the files of --objects.",
                   .choices = {"ply", "splat", "spz"}});
  words.AddOption(
      "sh-degree",
      &request->sh_degree,
      {.help = "Degree of the view-dependent colour in the file. Less than "
               "that of the scene makes smaller files, more adds zeros.",
       .choices = {"scene", "0", "1", "2", "3"}});
  words.AddThreads(&request->threads);
  words.RequireOneOf({"out", "objects"});
  return words;
}

StatusOr<ExportRequest> ParseExportRequest(
    const std::vector<std::string>& arguments) {
  ExportRequest request;
  CommandWords words = DescribeExport(&request);
  FREEGS_ASSIGN_OR_RETURN(const pipeline::OptionTable::CommandLine line,
                          words.Parse(arguments));
  FREEGS_RETURN_IF_ERROR(words.table().Apply(line.settings));
  bool format_given = false;
  for (const pipeline::OptionSetting& setting : line.settings) {
    format_given = format_given || setting.name == "format";
  }
  FREEGS_RETURN_IF_ERROR(CheckInstanceChoice(request.choice));
  FREEGS_RETURN_IF_ERROR(CheckWords(request, format_given));
  FREEGS_ASSIGN_OR_RETURN(request.workspace,
                          ExistingWorkspace(line.positional[0]));
  return request;
}

}  // namespace freegs::stages
