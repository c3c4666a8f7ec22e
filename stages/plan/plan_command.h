// SPDX-License-Identifier: BSD-3-Clause
// `freegs_pipeline plan WORKSPACE`: says what `run` would do, and how much
// time, memory and disk space each stage will need (docs/command_line.md).

#ifndef FREEGS_STAGES_PLAN_PLAN_COMMAND_H_
#define FREEGS_STAGES_PLAN_PLAN_COMMAND_H_

#include <ostream>
#include <string>
#include <vector>

#include "core/cancellation.h"
#include "core/status.h"
#include "stages/command_line/command_words.h"

namespace freegs::stages {

CommandWords PlanWords();

// Writes nothing but to `out`. kBadInput when there is neither the workspace
// nor a folder of photos.
Status RunPlan(const std::vector<std::string>& arguments,
               std::ostream& out,
               const CancellationToken& cancellation);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_PLAN_PLAN_COMMAND_H_
