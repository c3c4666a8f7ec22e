// SPDX-License-Identifier: BSD-3-Clause
// A vector of CLIP's space for every instance: F_ins of FreeGS ("Instance-level
// Feature Distillation"), and what is told apart by words.

#ifndef FREEGS_SEMANTICS_FIELD_INSTANCE_SEMANTICS_H_
#define FREEGS_SEMANTICS_FIELD_INSTANCE_SEMANTICS_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/cancellation.h"
#include "core/parallel.h"
#include "core/pinhole.h"
#include "core/status.h"
#include "semantics/clip/clip_encoder.h"
#include "semantics/field/feature_grids.h"
#include "splat/render/renderer.h"
#include "splat/scene/gaussian_model.h"

namespace freegs::semantics {

struct InstanceSemanticsOptions {
  // Photographs of each instance that go through the network: those that show
  // most of it. FreeGS takes all, every time it has clustered.
  int views_per_instance = 6;

  // Borders of masks by a conditional random field, as FreeGS does.
  bool refine = true;

  Status Check() const;
};

struct InstanceVectors {
  int dim = 0;
  std::vector<float> vectors;  // Instances x dim; of length 1, or zero where no
                               // view shows enough of an instance.
  size_t num_crops = 0;        // Cut out and encoded.
};

// The mean, of length 1, of what the encoder makes of an instance in its best
// views: cut out with what is around it, and alone. One vector whatever the
// view, where FreeGS has one for each: they are told apart by their instance
// only, and a view that shows little of it would teach what is not there.
//
// labels: of each Gaussian, -1 or an instance below num_instances. Errors as
// ComputeFeatureGrids.
StatusOr<InstanceVectors> EncodeInstances(
    const splat::GaussianModel& model,
    std::span<const View> views,
    const splat::RenderOptions& render,
    std::span<const int32_t> labels,
    int num_instances,
    ViewPhoto photo_of,
    ClipEncoder& encoder,
    const InstanceSemanticsOptions& options,
    ThreadPool& pool,
    const CancellationToken* cancellation,
    ViewsDone done);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_FIELD_INSTANCE_SEMANTICS_H_
