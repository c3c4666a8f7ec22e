// SPDX-License-Identifier: BSD-3-Clause
// A vector in CLIP's space for every instance: F_ins of FreeGS ("Instance-level
// Feature Distillation"). Words are compared with it.

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
  // How many photographs of each instance are encoded: those that show most of
  // it. FreeGS encodes all, after every clustering.
  int views_per_instance = 2;

  // Whether a conditional random field refines the borders of the masks, as in
  // FreeGS.
  bool refine = false;

  Status Check() const;
};

struct InstanceVectors {
  int dim = 0;
  // Instances x dim. A row has length 1, or is zero if no view shows enough of
  // the instance.
  std::vector<float> vectors;
  // How many pieces of photographs were cut out and encoded.
  size_t num_crops = 0;
};

// Returns, for each instance, the mean direction of what the encoder makes of
// it in its best views. In each view the instance is cut out once with its
// surroundings and once alone. FreeGS has a vector for each instance and view.
// One vector for all views is used here, because vectors need to tell apart
// instances only, and a view that shows little of an instance would teach what
// is not there.
//
// labels: for each Gaussian, -1 or an instance below num_instances. Errors as
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
