// SPDX-License-Identifier: BSD-3-Clause
// A vector in CLIP's space for every instance: F_ins of FreeGS ("Instance-level
// Feature Distillation"). Words are compared with it.

#ifndef FREEGS_SEMANTICS_FIELD_INSTANCE_SEMANTICS_H_
#define FREEGS_SEMANTICS_FIELD_INSTANCE_SEMANTICS_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "core/cancellation.h"
#include "core/image.h"
#include "core/parallel.h"
#include "core/pinhole.h"
#include "core/status.h"
#include "semantics/clip/clip_encoder.h"
#include "semantics/field/feature_grids.h"
#include "semantics/field/instance_crops.h"
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
  // Instances (or groups of them) x dim. A row has length 1, or is zero if no
  // view shows enough.
  std::vector<float> vectors = {};
  // How many pieces of photographs were cut out and encoded.
  size_t num_crops = 0;
};

// What shows the instances. The caller keeps everything that this refers to
// alive.
struct InstancePhotos {
  const splat::GaussianModel& model;
  std::span<const View> views;
  const splat::RenderOptions& render;
  ViewPhoto photo_of;
};

// Encodes instances, and several together as if they were one.
class InstanceEncoder {
 public:
  // `cancellation` may be null.
  InstanceEncoder(InstancePhotos photos,
                  ClipEncoder& encoder,
                  const InstanceSemanticsOptions& options,
                  ThreadPool& pool,
                  const CancellationToken* cancellation)
      : photos_(std::move(photos)),
        encoder_(encoder),
        options_(options),
        pool_(pool),
        cancellation_(cancellation) {}

  // Looks for the instances in all views. labels: for each Gaussian, -1 or an
  // instance below num_instances.
  Status Look(std::span<const int32_t> labels, int num_instances);

  // Returns, for each group of instances, the mean direction of what the
  // encoder makes of it in its best views. In each view the group is cut out
  // once with its surroundings and once alone. FreeGS has a vector for each
  // instance and view. One vector for all views is used here, because vectors
  // need to tell apart instances only, and a view that shows little of an
  // instance would teach what is not there. Errors as ComputeFeatureGrids.
  StatusOr<InstanceVectors> Encode(std::span<const std::vector<int32_t>> groups,
                                   ViewsDone done);

 private:
  // Refines the labels of a view, once.
  Status Refine(size_t view);

  InstancePhotos photos_;
  ClipEncoder& encoder_;
  InstanceSemanticsOptions options_;
  ThreadPool& pool_;
  const CancellationToken* cancellation_;
  // For each view: the label of each pixel, -1 for none, and how much of each
  // label there is before they are refined.
  std::vector<Image<int32_t>> maps_;
  std::vector<std::vector<LabelSight>> sights_;
  std::vector<uint8_t> refined_;
};

// The groups of one instance each.
std::vector<std::vector<int32_t>> EachAlone(int num_instances);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_FIELD_INSTANCE_SEMANTICS_H_
