// SPDX-License-Identifier: BSD-3-Clause
// `export WORKSPACE --out FILE`: writes the scene for other programs.

#ifndef FREEGS_STAGES_COMMANDS_EXPORT_COMMAND_H_
#define FREEGS_STAGES_COMMANDS_EXPORT_COMMAND_H_

#include <string>
#include <vector>

#include "core/status.h"
#include "stages/command_line/command_words.h"
#include "stages/commands/command.h"

namespace freegs::stages {

CommandWords ExportWords();

// --what chooses what is written:
//   color      the Gaussians, in their own colours
//   instances  the Gaussians, in the colours of their instances
//   masks      which pixels of the photos show which instance: COCO's JSON
//              (stages/export/instance_files.h)
//   boxes      the boxes of the instances: JSON, as export/boxes.json
//   colmap     undistort/sparse in the folder that --out names, as COLMAP's
//              text model
// For Gaussians the suffix of the file, in upper or lower case, chooses the
// format: .ply (splat/scene/ply_io.h), .splat (splat_format.h) or .spz
// (spz_format.h). --objects DIR writes, in place of one file, a file
// DIR/ID.ply of each instance, or of another format that --format names.
//
// --only 3,17 writes only these instances, --without 3,17 all others, and with
// them the Gaussians of no instance.
Status RunExportCommand(const std::vector<std::string>& arguments,
                        CommandContext& context);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_COMMANDS_EXPORT_COMMAND_H_
