// SPDX-License-Identifier: BSD-3-Clause
// Trains the semantic field by gradient descent, in turn with clustering
// (FreeGS, "Training and Testing"). The losses are pixel and instance
// distillation (eq. 7), smoothing (eq. 3) and the joint contrastive loss (eq.
// 8).
//
//   FREEGS_ASSIGN_OR_RETURN(
//       FieldTraining training,
//       FieldTraining::Create(scene, options, seed,
//                             FieldTraining::InitialState(
//                                 features, dim, feature_dim, options, seed),
//                             pool));
//   while (!training.finished()) {
//     if (training.clusters_next()) {
//       // Cluster training.features() and encode the instances.
//       FREEGS_RETURN_IF_ERROR(training.Teach(teachers, pool));
//     } else {
//       FREEGS_RETURN_IF_ERROR(training.Step(pool));
//     }
//   }

#ifndef FREEGS_SEMANTICS_FIELD_FIELD_TRAINING_H_
#define FREEGS_SEMANTICS_FIELD_FIELD_TRAINING_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/image.h"
#include "core/parallel.h"
#include "core/status.h"
#include "semantics/clip/joint_bilateral_upsampling.h"
#include "semantics/field/feature_grids.h"
#include "semantics/field/view_weights_store.h"
#include "semantics/losses/array_adam.h"
#include "semantics/losses/decoder_training.h"
#include "semantics/losses/feature_decoder.h"
#include "semantics/losses/joint_contrastive_loss.h"
#include "semantics/losses/smoothing_loss.h"
#include "splat/images/view_order.h"
#include "splat/render/renderer.h"
#include "splat/scene/gaussian_model.h"

namespace freegs::semantics {

struct FieldTrainingOptions {
  int iterations = 7000;

  // The number of pixels of one view whose features are compared in a step.
  // FreeGS compares all pixels.
  int pixels_per_step = 512;

  // The learning rate of the semantic vectors. The decoder has its own.
  double learning_rate = 2.5e-3;
  DecoderTrainingOptions decoder;
  int hidden_dim = 256;

  // The weights of the losses. 0 leaves a loss out. Pixel distillation has
  // weight 1.
  double instance_weight = 0.3;      // gamma
  double smoothing_weight = 0.1;     // lambda_S
  double contrastive_weight = 0.05;  // lambda_C

  // The first step with a smoothing loss, as in the released code of FreeGS.
  int smoothing_start = 1000;

  SmoothingOptions smoothing;
  ContrastiveOptions contrastive;

  // The Gaussians are clustered before step cluster_start, and then every
  // cluster_interval steps. The losses that need instances begin with the first
  // clustering. A start of 0 never clusters.
  int cluster_start = 3000;
  int cluster_interval = 2000;

  // Training ends when two clusterings in a row have at least this adjusted
  // Rand index. Above 1 it always runs to the last step.
  double settled_index = 0.98;

  Status Check() const;
};

// What the instances of a clustering look like in the training views.
struct InstanceTeachers {
  int num_instances = 0;
  std::vector<int32_t> labels;  // For each Gaussian; -1 for none.
  std::vector<float> vectors;   // num_instances x C; zero where unknown.
};

// One clustering during training.
struct ClusteringRound {
  int64_t step = 0;
  int32_t num_instances = 0;
  double agreement = 0;  // Adjusted Rand index with the one before, or 0.
};

// The values of the losses without their weights.
struct FieldLosses {
  double pixel = 0;
  double instance = 0;
  double smoothing = 0;
  double contrastive = 0;
};

// The mean losses of the steps since the record before, up to `step`.
struct LossRecord {
  int64_t step = 0;
  FieldLosses losses;
};

// Everything that changes while the field is trained. Training can continue
// from it.
struct FieldState {
  int64_t step = 0;
  std::vector<float> features;  // f, N x D
  ArrayAdamState feature_adam;
  FeatureDecoder decoder;  // From D to C.
  ArrayAdamState decoder_adam;
  InstanceTeachers teachers;  // Those of the last clustering.
  std::vector<ClusteringRound> rounds;
  std::vector<LossRecord> history;
  FieldLosses sums;    // Sums of the losses since the last record,
  FieldLosses counts;  // and how many values each sum has.

  int dim() const { return decoder.latent_dim(); }
};

class FieldTraining {
 public:
  // What the field is trained on. Everything that this refers to must outlive
  // the training.
  struct Scene {
    const splat::GaussianModel& model;
    std::span<const View> views;
    splat::RenderOptions render;
    const FeatureGrids& grids;       // Per view.
    std::span<const ImageF> guides;  // Photographs at the size of the weights.
    const JointBilateralOptions& upsampling;
    ViewWeightsStore& weights;
  };

  // Returns a state to begin with: the given vectors, N x dim, and a random
  // decoder to feature_dim numbers.
  static FieldState InitialState(std::vector<float> features,
                                 int dim,
                                 int feature_dim,
                                 const FieldTrainingOptions& options,
                                 uint64_t seed);

  // Continues from `state`. kInvalidArgument for options out of range, and for
  // a state of another scene.
  static StatusOr<FieldTraining> Create(const Scene& scene,
                                        const FieldTrainingOptions& options,
                                        uint64_t seed,
                                        FieldState state,
                                        ThreadPool& pool);

  // Takes one step. The result has the same bytes for any number of threads,
  // and whether or not training was interrupted. kUnusableResult if gradients
  // are not finite.
  Status Step(ThreadPool& pool);

  // True after the last step, and after two clusterings in a row that agree.
  bool finished() const;

  // True if the Gaussians are to be clustered before the next step.
  bool clusters_next() const;

  // Takes the outcome of a clustering. Instances and their pixels are taught by
  // it from now on. kInvalidArgument for labels of another number of Gaussians.
  Status Teach(InstanceTeachers teachers, ThreadPool& pool);

  int64_t step() const { return step_; }
  std::span<const float> features() const { return features_; }
  const std::vector<ClusteringRound>& rounds() const { return rounds_; }
  const std::vector<LossRecord>& history() const { return history_; }
  FieldState state() const;

 private:
  // The sampled pixels of one view.
  struct Batch {
    size_t view = 0;
    std::vector<uint32_t> rows;      // S: pixels, as rows of the weights.
    std::vector<float> latents;      // S x D, blended.
    std::vector<int32_t> instances;  // S; empty before the first clustering.
  };

  FieldTraining(const Scene& scene,
                const FieldTrainingOptions& options,
                uint64_t seed,
                FieldState state);

  // Draws pixels from this step's view and blends the vectors there.
  StatusOr<Batch> Sample(const splat::WeightMatrix& weights, ThreadPool& pool);
  // Returns F_pix of eq. 7 at the pixels of the batch, S x C.
  StatusOr<std::vector<float>> PixelTargets(const Batch& batch,
                                            ThreadPool& pool) const;
  // Each of these adds the gradients of its loss and counts its value.
  Status Distil(const Batch& batch, ThreadPool& pool);
  Status Contrast(const Batch& batch, ThreadPool& pool);
  Status Smooth(ThreadPool& pool);
  void RecordLosses();
  // Renders the instances of teachers_ in every view.
  void ShowTeachers(ThreadPool& pool);

  Scene scene_;
  FieldTrainingOptions options_;
  uint64_t seed_;
  int64_t step_;
  std::vector<float> features_;
  ArrayAdamState feature_adam_;
  std::unique_ptr<FeatureDecoder> decoder_;  // decoder_training_ points to it.
  DecoderTraining decoder_training_;
  InstanceTeachers teachers_;
  splat::ViewOrder order_;
  NeighborTable neighbors_;
  std::vector<Image<int32_t>> instance_maps_;  // Per view, at weights' size.
  std::vector<uint8_t> known_;                 // Per instance.

  // Gradients of the step in progress.
  std::vector<float> latent_gradients_;   // S x D
  std::vector<float> feature_gradients_;  // N x D
  std::vector<ClusteringRound> rounds_;
  std::vector<LossRecord> history_;
  FieldLosses sums_;
  FieldLosses counts_;
};

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_FIELD_FIELD_TRAINING_H_
