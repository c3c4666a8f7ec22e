// SPDX-License-Identifier: BSD-3-Clause
// The stages of the pipeline, in their order.

#ifndef FREEGS_STAGES_REGISTRY_STAGE_REGISTRY_H_
#define FREEGS_STAGES_REGISTRY_STAGE_REGISTRY_H_

#include <vector>

#include "pipeline/option_table.h"
#include "pipeline/stage_state.h"
#include "stages/registry/pipeline_options.h"

namespace freegs::stages {

// Makes the stages from the options; `table` is the table over the same
// options, from which stage.json gets their text.
std::vector<pipeline::RunnerStage> MakeStages(
    const PipelineOptions& options, const pipeline::OptionTable& table);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_REGISTRY_STAGE_REGISTRY_H_
