// SPDX-License-Identifier: BSD-3-Clause
// Phase 2 of FreeGS: gives every Gaussian a semantic vector and an instance
// index, learnt from photographs without labels. The geometry is frozen.
//
//   const PosedScene scene{model, train_views, all_views, render};
//   const FeatureCache cache(folder);
//   BootstrapTools tools{*encoder, cache, pool, nullptr, nullptr,
//                        std::nullopt, nullptr};
//   FREEGS_ASSIGN_OR_RETURN(
//       const SemanticField field,
//       BootstrapSemanticField(
//           scene, photo_of, BootstrappingOptions(), seed,
//           std::move(tools)));
//   // field.features, field.instances.labels and field.vectors are the result.

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
#include "semantics/field/instance_semantics.h"
#include "semantics/field/named_wholes.h"
#include "semantics/field/view_weights_store.h"
#include "semantics/instances/instance_clustering.h"
#include "splat/render/renderer.h"
#include "splat/scene/gaussian_model.h"

namespace freegs::semantics {

// Where the semantic vectors come from.
enum class FieldMethod {
  kLift,   // Averages of the features of photographs, in one pass.
  kTrain,  // By gradient descent, from these or from random ones.
};

struct BootstrappingOptions {
  FieldMethod method = FieldMethod::kLift;
  FeatureGridOptions features;
  JointBilateralOptions upsampling;
  ViewWeightsOptions weights;
  InstanceClusteringOptions clustering;
  InstanceSemanticsOptions instances;

  // For kTrain. random_start: training begins with random vectors and not
  // with the lifted ones. Those of Gaussians that no view shows stay zero. (In
  // the released code of FreeGS all vectors begin at zero; the paper does not
  // say.)
  FieldTrainingOptions training;
  bool random_start = false;

  Status Check() const;
};

// What phase 2 looks at. The caller keeps everything that this refers to alive.
struct PosedScene {
  const splat::GaussianModel& model;
  std::span<const View> views;      // The views of the photographs that teach.
  std::span<const View> all_views;  // With the held-out ones; for clustering.
  splat::RenderOptions render;
};

// What phase 2 works with.
struct BootstrapTools {
  ClipEncoder& encoder;
  const FeatureCache& cache;
  ThreadPool& pool;
  const CancellationToken* cancellation;  // May be null.
  ProgressFn progress;

  // If set, training continues from this state. `save`, if not null, gets the
  // training every 50 steps, and once more with stopping = true when training
  // has ended or stops because it was cancelled. If it returns an error,
  // training ends with that error.
  std::optional<FieldState> resume_from;
  std::function<Status(const FieldTraining& training, bool stopping)> save;

  // What the encoder recognises. With clustering by evidence, instances that
  // are recognised together are one.
  KnownThings things = {};
};

// The result of phase 2.
struct SemanticField {
  // The vectors of the Gaussians, N x D. A vector is zero if no view shows the
  // Gaussian; num_unseen counts these.
  std::vector<float> features;
  size_t num_unseen = 0;
  // Leads from vectors of D numbers to CLIP's features.
  FeatureDecoder decoder{LinearDecoder()};
  InstanceLabels instances;

  // One vector per instance, in CLIP's space, of length 1 or zero. Words and
  // images are compared with it. Of a trained field it is that of
  // MeanInstanceVectors(), else what the encoder says of pictures of the
  // instance.
  InstanceVectors vectors;

  // The course of training.
  int64_t steps = 0;
  std::vector<ClusteringRound> rounds;
  std::vector<LossRecord> losses;

  // The wall time of each part in seconds, in the order of the parts.
  std::vector<std::pair<std::string, double>> seconds;
};

// The features of all photographs are averaged onto the Gaussians, with the
// weights with which these are blended. If asked for, training continues from
// there, in turn with clustering. Then the Gaussians are clustered by geometry,
// colour and semantics, and every instance is encoded in the photographs that
// show it best. kInterrupted when cancelled; errors of the parts.
StatusOr<SemanticField> BootstrapSemanticField(
    const PosedScene& scene,
    ViewPhoto photo_of,
    const BootstrappingOptions& options,
    uint64_t seed,
    BootstrapTools tools);

// Returns the mean feature of the Gaussians of each instance in CLIP's space,
// of length 1. It is zero for an instance that no view shows. The mean is over
// the directions of the decoded vectors, weighted by how much the views show of
// each Gaussian. (FreeGS, "Testing", takes the average without weights.)
// features: N x D. weights: N, the sums of the blending weights.
StatusOr<std::vector<float>> MeanInstanceVectors(
    std::span<const float> features,
    std::span<const double> weights,
    std::span<const int32_t> labels,
    int num_instances,
    const FeatureDecoder& decoder,
    ThreadPool& pool);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_FIELD_BOOTSTRAPPING_H_
