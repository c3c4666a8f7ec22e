// SPDX-License-Identifier: BSD-3-Clause
// The semantic field learnt by gradient descent, in turn with clustering
// (FreeGS, "Training and Testing"): pixel and instance distillation (eq. 8),
// smoothing (eq. 3) and the joint contrastive loss (eq. 9).

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

  // Pixels of one view whose features are compared in a step. FreeGS: all.
  int pixels_per_step = 512;

  // Of the semantic vectors; the decoder has its own.
  double learning_rate = 2.5e-3;
  DecoderTrainingOptions decoder;
  int hidden_dim = 256;

  // Weights of the losses; 0 leaves one out. Pixel distillation has weight 1.
  double instance_weight = 0.3;      // gamma
  double smoothing_weight = 0.1;     // lambda_S
  double contrastive_weight = 0.05;  // lambda_C

  // Smoothing and contrastive loss are computed every so many steps, the former
  // from the first step on that the released code gives it.
  int smoothing_start = 1000;

  SmoothingOptions smoothing;
  ContrastiveOptions contrastive;

  // Steps after which Gaussians are clustered, the first time and then again;
  // what needs instances begins with the first. 0 never clusters.
  int cluster_start = 3000;
  int cluster_interval = 2000;

  // Training ends when two clusterings in a row agree to this adjusted Rand
  // index; above 1, never before its last step.
  double settled_index = 0.98;

  Status Check() const;
};

// What the instances of a clustering look like in the training views.
struct InstanceTeachers {
  int num_instances = 0;
  std::vector<int32_t> labels;  // Of Gaussians; -1 for none.
  std::vector<float> vectors;   // num_instances x C; zero where unknown.
};

// One clustering during training.
struct ClusteringRound {
  int64_t step = 0;
  int32_t num_instances = 0;
  double agreement = 0;  // Adjusted Rand index with the one before; 0 without.
};

// Mean values of the losses, without their weights.
struct FieldLosses {
  double pixel = 0;
  double instance = 0;
  double smoothing = 0;
  double contrastive = 0;
};

// Those of the steps up to `step` since the entry before.
struct LossRecord {
  int64_t step = 0;
  FieldLosses losses;
};

// What changes while the field is trained: enough to go on from.
struct FieldState {
  int64_t step = 0;
  std::vector<float> features;  // f, N x D
  ArrayAdamState feature_adam;
  FeatureDecoder decoder;  // From D to C.
  ArrayAdamState decoder_adam;
  InstanceTeachers teachers;  // Of the last clustering.
  std::vector<ClusteringRound> rounds;
  std::vector<LossRecord> history;
  FieldLosses sums;    // Since the last entry of the history:
  FieldLosses counts;  // and of how many values.

  int dim() const { return decoder.latent_dim(); }
};

class FieldTraining {
 public:
  // What it learns from; all referred to outlives this.
  struct Scene {
    const splat::GaussianModel& model;
    std::span<const View> views;
    splat::RenderOptions render;
    const FeatureGrids& grids;       // Per view.
    std::span<const ImageF> guides;  // Photographs at the weights' size.
    const JointBilateralOptions& upsampling;
    ViewWeightsStore& weights;
  };

  // A state to begin with: the given vectors, N x D, and a random decoder.
  static FieldState InitialState(std::vector<float> features,
                                 int dim,
                                 int feature_dim,
                                 const FieldTrainingOptions& options,
                                 uint64_t seed);

  // Takes up the state. kInvalidArgument for options out of range and for a
  // state of another scene.
  static StatusOr<FieldTraining> Create(const Scene& scene,
                                        const FieldTrainingOptions& options,
                                        uint64_t seed,
                                        FieldState state,
                                        ThreadPool& pool);

  // One step. The same bytes for any number of threads, and whether or not
  // training was interrupted. kUnusableResult when values are not finite any
  // more.
  Status Step(ThreadPool& pool);

  // After the last step, or when two clusterings in a row were alike.
  bool finished() const;

  // Whether Gaussians are to be clustered before the next step.
  bool clusters_next() const;

  // The outcome of that: what instances and their pixels are taught from now.
  // kInvalidArgument for labels of another number of Gaussians.
  Status Teach(InstanceTeachers teachers, ThreadPool& pool);

  int64_t step() const { return step_; }
  std::span<const float> features() const { return features_; }
  const FeatureDecoder& decoder() const { return *decoder_; }
  const InstanceTeachers& teachers() const { return teachers_; }
  const std::vector<ClusteringRound>& rounds() const { return rounds_; }
  const std::vector<LossRecord>& history() const { return history_; }
  FieldState state() const;

 private:
  // Pixels of one view.
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

  // Pixels of this step's view and what is blended onto them.
  StatusOr<Batch> Sample(const splat::WeightMatrix& weights, ThreadPool& pool);
  // F_pix of eq. 8 at the batch's pixels, S x C.
  StatusOr<std::vector<float>> PixelTargets(const Batch& batch,
                                            ThreadPool& pool) const;
  // Each adds its loss' gradients and counts its value.
  Status Distil(const Batch& batch, ThreadPool& pool);
  Status Contrast(const Batch& batch, ThreadPool& pool);
  Status Smooth(ThreadPool& pool);
  void RecordLosses();
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

  // Of the step in progress.
  std::vector<float> latent_gradients_;   // S x D
  std::vector<float> feature_gradients_;  // N x D
  std::vector<ClusteringRound> rounds_;
  std::vector<LossRecord> history_;
  FieldLosses sums_;
  FieldLosses counts_;
};

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_FIELD_FIELD_TRAINING_H_
