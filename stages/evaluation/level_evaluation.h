// SPDX-License-Identifier: BSD-3-Clause
// How well the objects of the truth could be met if each of them were asked for
// at the level of the hierarchy, whole or part, that fits it best.

#ifndef FREEGS_STAGES_EVALUATION_LEVEL_EVALUATION_H_
#define FREEGS_STAGES_EVALUATION_LEVEL_EVALUATION_H_

#include <cstdint>
#include <optional>
#include <span>

#include "core/status.h"
#include "semantics/instances/hierarchy.h"
#include "stages/evaluation/evaluation_context.h"

namespace freegs::stages {

// The mean IoU over all pairs of view and object, as in
// InstanceQuality::instance_miou. Each object is compared with one answer in
// all views: an instance or a region of the hierarchy, whichever has the
// highest IoU over all views together. The mask of a region has the pixels that
// show more of it than of any instance beside it. It is what `query --narrower`
// gives; what `query --wider` gives also has those Gaussians of the clicked
// instance that are of no part. `instance_of_gaussian`: negative for none.
// Nothing when the truth has no masks of test views. The errors are those of
// EvaluationContext::ForEachView.
StatusOr<std::optional<double>> MeasureBestLevels(
    const EvaluationContext& context,
    std::span<const int32_t> instance_of_gaussian,
    const semantics::Hierarchy& hierarchy);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_EVALUATION_LEVEL_EVALUATION_H_
