// SPDX-License-Identifier: BSD-3-Clause
// Writes the figures of stage bootstrap.

#ifndef FREEGS_STAGES_BOOTSTRAP_BOOTSTRAP_METRICS_H_
#define FREEGS_STAGES_BOOTSTRAP_BOOTSTRAP_METRICS_H_

#include <cstddef>
#include <vector>

#include "core/status.h"
#include "pipeline/resource_usage.h"
#include "pipeline/stage.h"
#include "semantics/field/bootstrapping.h"
#include "semantics/instances/instances.h"
#include "stages/bootstrap/bootstrap_options.h"

namespace freegs::stages {

// Writes metrics.json below context.output, and progress.csv when the field was
// trained (mode paper). docs/outputs.md describes both. `meter` was started
// with the stage. Sets context.summary.
Status WriteBootstrapMetrics(const BootstrapStageOptions& options,
                             size_t num_gaussians,
                             const semantics::SemanticField& field,
                             const std::vector<semantics::Instance>& instances,
                             int num_words_withheld,
                             const pipeline::ResourceMeter& meter,
                             pipeline::StageContext& context);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_BOOTSTRAP_BOOTSTRAP_METRICS_H_
