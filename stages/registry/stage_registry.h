// SPDX-License-Identifier: BSD-3-Clause
// The stages of the pipeline, in their order. The commands `run` and `stage`
// make and run them like this (stages/commands/run_command.cc):
//
//   PipelineOptions options;
//   pipeline::OptionTable table = MakeOptionTable(&options);
//   FREEGS_RETURN_IF_ERROR(ApplySettings(workspace, settings, table));
//   pipeline::StageRunner runner(MakeStages(options, table),
//                                {.workspace = workspace, .images = photos},
//                                cancellation,
//                                logger);
//   FREEGS_RETURN_IF_ERROR(runner.Run());
//
// The runner calls Stage::Run with a StageContext (pipeline/stage.h) for each
// stage whose result is missing or does not hold any more.

#ifndef FREEGS_STAGES_REGISTRY_STAGE_REGISTRY_H_
#define FREEGS_STAGES_REGISTRY_STAGE_REGISTRY_H_

#include <filesystem>
#include <string>
#include <vector>

#include "core/status.h"
#include "pipeline/option_table.h"
#include "pipeline/stage_state.h"
#include "stages/registry/pipeline_options.h"

namespace freegs::stages {

// Makes the stages from `options`. `table` is the table over the same options;
// it gives the options' text for stage.json and for the fingerprints.
std::vector<pipeline::RunnerStage> MakeStages(
    const PipelineOptions& options, const pipeline::OptionTable& table);

// The names of the stages, in their order.
std::vector<std::string> StageNames();

// The stage in whose folder a path lies, or in that of its unfinished run;
// empty if it lies in none.
std::string StageThatHolds(const std::filesystem::path& workspace,
                           const std::filesystem::path& path);

// kInvalidArgument for photos in the folder of a stage of this workspace: what
// the stages write there would be taken for other photos after each run.
Status CheckPhotosPlace(const std::filesystem::path& workspace,
                        const std::filesystem::path& images);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_REGISTRY_STAGE_REGISTRY_H_
