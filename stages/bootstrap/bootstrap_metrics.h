// SPDX-License-Identifier: BSD-3-Clause
// The figures that stage bootstrap leaves behind.

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

// metrics.json and, of a trained field, progress.csv below the stage's output;
// docs/outputs.md says what is in them. Sets context.summary.
Status WriteBootstrapMetrics(const BootstrapStageOptions& options,
                             size_t num_gaussians,
                             const semantics::SemanticField& field,
                             const std::vector<semantics::Instance>& instances,
                             const pipeline::ResourceMeter& meter,
                             pipeline::StageContext& context);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_BOOTSTRAP_BOOTSTRAP_METRICS_H_
