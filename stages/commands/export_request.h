// SPDX-License-Identifier: BSD-3-Clause
// What `export` is asked for on its command line.

#ifndef FREEGS_STAGES_COMMANDS_EXPORT_REQUEST_H_
#define FREEGS_STAGES_COMMANDS_EXPORT_REQUEST_H_

#include <array>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/status.h"
#include "stages/command_line/command_words.h"
#include "stages/commands/instance_choice.h"

namespace freegs::stages {

struct ExportRequest {
  std::filesystem::path workspace;
  std::string out;      // A file, or a folder for colmap.
  std::string objects;  // A folder, in place of `out`.
  std::string format = "ply";
  std::string what = "color";
  InstanceChoice choice;
  std::string sh_degree = "scene";  // Or "0" to "3".
  int threads = 0;
};

// The words of the command; they set the request.
CommandWords DescribeExport(ExportRequest* request);

// Returns kInvalidArgument for words that do not fit each other, before
// anything is read or written. Returns kBadInput when there is no workspace.
StatusOr<ExportRequest> ParseExportRequest(
    const std::vector<std::string>& arguments);

// Suffixes of files of Gaussians.
inline constexpr std::array<std::string_view, 3> kGaussianSuffixes = {
    ".ply", ".splat", ".spz"};

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_COMMANDS_EXPORT_REQUEST_H_
