// SPDX-License-Identifier: BSD-3-Clause
// Phase 2 of FreeGS: a semantic vector and an instance index for every
// Gaussian, learned from photographs without labels. The geometry is frozen.

#ifndef FREEGS_SEMANTICS_FIELD_BOOTSTRAPPING_H_
#define FREEGS_SEMANTICS_FIELD_BOOTSTRAPPING_H_

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/cancellation.h"
#include "core/parallel.h"
#include "core/pinhole.h"
#include "core/status.h"
#include "semantics/clip/clip_encoder.h"
#include "semantics/clip/feature_cache.h"
#include "semantics/clip/joint_bilateral_upsampling.h"
#include "semantics/field/feature_grids.h"
#include "semantics/field/feature_lifting.h"
#include "semantics/field/field_training.h"
#include "semantics/instances/instance_clustering.h"
#include "semantics/field/instance_semantics.h"
#include "semantics/field/view_weights_store.h"
#include "splat/scene/gaussian_model.h"
#include "splat/render/renderer.h"

namespace freegs::semantics {

// Where semantic vectors come from.
enum class FieldMethod {
  kLift,   // Averages of the photographs' features, in one pass.
  kTrain,  // From there, or from random vectors, by gradient descent.
};

struct BootstrappingOptions {
  FieldMethod method = FieldMethod::kLift;
  FeatureGridOptions features;
  JointBilateralOptions upsampling;
  ViewWeightsOptions weights;
  InstanceClusteringOptions clustering;
  InstanceSemanticsOptions instances;

  // What an instance's vector is made of: this share of what the encoder makes
  // of the instance cut out, the rest the mean of its Gaussians' vectors. The
  // paper asks the Gaussians only, which training has drawn to both.
  double instance_share = 0.5;

  // For kTrain.
  FieldTrainingOptions training;
  bool random_start = false;  // As FreeGS; otherwise from what was lifted.

  Status Check() const;
};

// What phase 2 looks at. Everything referred to outlives it.
struct PosedScene {
  const splat::GaussianModel& model;
  std::span<const View> views;  // Of the photographs that teach.
  std::span<const View> all_views;
  splat::RenderOptions render;
};

// What it works with.
struct BootstrapTools {
  ClipEncoder& encoder;
  const FeatureCache& cache;
  ThreadPool& pool;
  const CancellationToken* cancellation;  // May be null.
  ProgressFn progress;

  // Training goes on from this state, if there is one, and gives its own to
  // `save` when it thinks fit (null: never): often, and before it stops because
  // it was cancelled. A save that fails ends the training.
  std::optional<FieldState> resume_from;
  std::function<Status(const FieldTraining& training, bool stopping)> save;
};

struct SemanticField {
  // Of each Gaussian, N x D; zero where no view shows it.
  std::vector<float> features;
  size_t num_unseen = 0;
  // From D to CLIP's numbers.
  FeatureDecoder decoder{LinearDecoder()};
  InstanceLabels instances;

  // Of each instance, in CLIP's space, of length 1 or zero: what words and
  // images are compared with.
  InstanceVectors vectors;

  // Of training.
  int64_t steps = 0;
  std::vector<ClusteringRound> rounds;
  std::vector<LossRecord> losses;

  // Wall seconds of each part, in order.
  std::vector<std::pair<std::string, double>> seconds;
};

// The features of all photographs are averaged onto the Gaussians by the
// weights with which these are blended; training, if asked for, goes on from
// there, in turn with clustering. Gaussians are clustered by geometry, colour
// and semantics, and every instance is looked at in the photographs that show
// it best. Errors of its parts.
StatusOr<SemanticField> BootstrapSemanticField(
    const PosedScene& scene,
    ViewPhoto photo_of,
    const BootstrappingOptions& options,
    uint64_t seed,
    const BootstrapTools& tools);

// The mean feature of each instance's Gaussians, in CLIP's space and of length
// 1, or zero for an instance that no view shows: of the directions of their
// decoded vectors, weighted by how much is seen of them (FreeGS, "Testing").
// features: N x D; weights: N.
StatusOr<std::vector<float>> MeanInstanceVectors(
    std::span<const float> features,
    std::span<const double> weights,
    std::span<const int32_t> labels,
    int num_instances,
    const FeatureDecoder& decoder,
    ThreadPool& pool);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_FIELD_BOOTSTRAPPING_H_
