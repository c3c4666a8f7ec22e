// SPDX-License-Identifier: BSD-3-Clause
// Phase 2 of FreeGS: a semantic vector and an instance index for every
// Gaussian, learned from photographs without labels. The geometry is frozen.

#ifndef FREEGS_SEMANTICS_BOOTSTRAPPING_H_
#define FREEGS_SEMANTICS_BOOTSTRAPPING_H_

#include <cstddef>
#include <cstdint>
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
#include "semantics/feature_grids.h"
#include "semantics/feature_lifting.h"
#include "semantics/instance_clustering.h"
#include "semantics/instance_semantics.h"
#include "semantics/view_weights_store.h"
#include "splat/gaussian_model.h"
#include "splat/renderer.h"

namespace freegs::semantics {

struct BootstrappingOptions {
  FeatureGridOptions features;
  JointBilateralOptions upsampling;
  ViewWeightsOptions weights;
  InstanceClusteringOptions clustering;
  InstanceSemanticsOptions instances;

  // What an instance's vector is made of: this share of what the encoder makes
  // of the instance cut out, the rest the mean of its Gaussians' vectors. The
  // paper asks the Gaussians only, which training has drawn to both.
  double instance_share = 0.5;

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
};

struct SemanticField {
  // Of each Gaussian, N x D; zero where no view shows it.
  LiftedFeatures lifted;
  PrincipalAxes axes;  // From D back to CLIP's numbers.
  InstanceLabels instances;

  // Of each instance, in CLIP's space, of length 1 or zero: what words and
  // images are compared with.
  InstanceVectors vectors;

  // Wall seconds of each step, in order.
  std::vector<std::pair<std::string, double>> seconds;
};

// Without iterations: the features of all photographs are averaged onto the
// Gaussians by the weights with which these are blended, and clustered together
// with geometry and colour. Errors of its parts; kUnusableResult when no
// instance is found.
StatusOr<SemanticField> LiftSemanticField(const PosedScene& scene,
                                          ViewPhoto photo_of,
                                          const BootstrappingOptions& options,
                                          uint64_t seed,
                                          const BootstrapTools& tools);

// Mean semantic vectors of instances in CLIP's space, each of length 1 or zero:
// of its Gaussians' directions, weighted by how much is seen of them.
// vectors: N x D.
std::vector<float> MeanInstanceVectors(std::span<const float> vectors,
                                       std::span<const double> weights,
                                       std::span<const int32_t> labels,
                                       int num_instances,
                                       const PrincipalAxes& axes,
                                       ThreadPool& pool);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_BOOTSTRAPPING_H_
