// SPDX-License-Identifier: BSD-3-Clause
// All options of the pipeline in one struct, and the table that reads them.
//
//   PipelineOptions options;
//   pipeline::OptionTable table = MakeOptionTable(&options);
//   FREEGS_ASSIGN_OR_RETURN(const pipeline::OptionTable::CommandLine line,
//                           table.ParseCommandLine(arguments));
//   FREEGS_RETURN_IF_ERROR(ApplySettings(workspace, line.settings, table));
//   options.reconstruct.iterations;   // from preset, config.ini, command line

#ifndef FREEGS_STAGES_REGISTRY_PIPELINE_OPTIONS_H_
#define FREEGS_STAGES_REGISTRY_PIPELINE_OPTIONS_H_

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/status.h"
#include "pipeline/option_table.h"
#include "pipeline/workspace.h"
#include "semantics/queries/text_query.h"
#include "stages/bootstrap/bootstrap_stage.h"
#include "stages/export/export_stage.h"
#include "stages/ingest/ingest_stage.h"
#include "stages/reconstruct/reconstruct_stage.h"
#include "stages/sfm/sfm_stage.h"
#include "stages/sfm/undistort_stage.h"

namespace freegs::stages {

// Options that concern more than one stage.
struct GeneralOptions {
  // A named set of option values; see presets.h.
  std::string preset = "balanced";

  // Number of threads; 0 takes one per available core. Results do not depend on
  // it.
  int threads = 0;

  // The start of every random sequence. The same seed gives the same bytes.
  int64_t seed = 0;

  // Seconds between checkpoints of long stages.
  double checkpoint_interval = 60;

  // Whether details are logged, too.
  bool verbose = false;
};

struct PipelineOptions {
  GeneralOptions general;
  IngestStageOptions ingest;
  SfmStageOptions sfm;
  UndistortStageOptions undistort;
  ReconstructStageOptions reconstruct;
  BootstrapStageOptions bootstrap;
  ExportStageOptions export_;  // "export" is a word of the language.
  semantics::TextQueryOptions query;
};

// Makes the table of all options; `options` must outlive it.
pipeline::OptionTable MakeOptionTable(PipelineOptions* options);

// Returns the settings of WORKSPACE/config.ini, none if there is no such file.
// kBadInput for one that cannot be read, also for a link that leads nowhere.
StatusOr<std::vector<pipeline::OptionSetting>> ConfigSettings(
    const std::filesystem::path& workspace, const pipeline::OptionTable& table);

// Sets the options of a table from MakeOptionTable. Later sources override
// earlier ones: the preset (named on the command line, else in config.ini, else
// the default one), then WORKSPACE/config.ini if it exists, then the command
// line. Preset auto has the values `chosen`, and is an error where there are
// none. kInvalidArgument names the option and the fault.
Status ApplySettings(const std::filesystem::path& workspace,
                     const std::vector<pipeline::OptionSetting>& command_line,
                     pipeline::OptionTable& table,
                     const std::vector<pipeline::OptionSetting>& chosen = {});

// Returns the settings of earlier command lines, which workspace.json keeps.
// Settings that the table does not know any more are left out.
std::vector<pipeline::OptionSetting> RememberedSettings(
    const std::filesystem::path& workspace,
    const pipeline::WorkspaceInfo& info,
    const pipeline::OptionTable& table);

// Does what ApplySettings does, for commands that ask about a finished scene:
// of what the workspace remembers they use the preset and section query. Errors
// also as ReadWorkspaceInfo.
Status ApplyQuerySettings(
    const std::filesystem::path& workspace,
    const std::vector<pipeline::OptionSetting>& command_line,
    pipeline::OptionTable& table);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_REGISTRY_PIPELINE_OPTIONS_H_
