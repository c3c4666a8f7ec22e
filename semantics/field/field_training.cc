// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/field/field_training.h"

#include <algorithm>
#include <string>
#include <utility>

#include "core/random.h"
#include "semantics/losses/all_finite.h"
#include "semantics/losses/instance_distillation_loss.h"
#include "semantics/losses/pixel_distillation_loss.h"
#include "semantics/metrics/adjusted_rand_index.h"
#include "splat/weights/blending_products.h"

namespace freegs::semantics {
namespace {

// Streams of random numbers.
constexpr uint64_t kPixelStream = 0x7069786c;
constexpr uint64_t kGaussianStream = 0x67617573;

constexpr int64_t kStepsPerRecord = 100;
// Smoothing and contrastive loss are computed every so many steps, as in
// FreeGS.
constexpr int64_t kSlowInterval = 10;
// Gaussians that the contrastive loss samples for a step.
constexpr size_t kContrastiveGaussians = 2048;

void Count(double value, double* sum, double* count) {
  *sum += value;
  *count += 1;
}

double Mean(double sum, double count) { return count > 0 ? sum / count : 0; }

}  // namespace

Status FieldTrainingOptions::Check() const {
  if (iterations < 0 || pixels_per_step < 1 || pixels_per_step > (1 << 20)) {
    return InvalidArgumentError(
        "iterations must not be negative and pixels_per_step must lie in 1 .. "
        "1048576");
  }
  if (hidden_dim < 1 || smoothing_start < 0 || cluster_start < 0 ||
      cluster_interval < 1) {
    return InvalidArgumentError(
        "hidden_dim and cluster_interval must be positive, smoothing_start and "
        "cluster_start not negative");
  }
  for (const double value : {learning_rate,
                             instance_weight,
                             smoothing_weight,
                             contrastive_weight,
                             settled_index}) {
    if (!(value >= 0 && value <= 1e6)) {
      return InvalidArgumentError(
          "learning rate, weights of losses and settled_index must lie in 0 .. "
          "1e6");
    }
  }
  FREEGS_RETURN_IF_ERROR(decoder.Check());
  FREEGS_RETURN_IF_ERROR(smoothing.Check());
  return contrastive.Check();
}

FieldState FieldTraining::InitialState(std::vector<float> features,
                                       int dim,
                                       int feature_dim,
                                       const FieldTrainingOptions& options,
                                       uint64_t seed) {
  const MlpShape shape{dim, options.hidden_dim, feature_dim};
  const size_t size = features.size();
  return {.step = 0,
          .features = std::move(features),
          .feature_adam = ArrayAdamState::OfSize(size),
          .decoder = FeatureDecoder(RandomMlpDecoder(shape, seed)),
          .decoder_adam = ArrayAdamState::OfSize(shape.num_parameters()),
          .teachers = {},
          .rounds = {},
          .history = {},
          .sums = {},
          .counts = {}};
}

FieldTraining::FieldTraining(const Scene& scene,
                             const FieldTrainingOptions& options,
                             uint64_t seed,
                             FieldState state)
    : scene_(scene),
      options_(options),
      seed_(seed),
      step_(state.step),
      features_(std::move(state.features)),
      feature_adam_(std::move(state.feature_adam)),
      decoder_(std::make_unique<FeatureDecoder>(std::move(state.decoder))),
      decoder_training_(options.decoder, decoder_.get()),
      teachers_(std::move(state.teachers)),
      order_(seed, scene.weights.num_views()),
      rounds_(std::move(state.rounds)),
      history_(std::move(state.history)),
      sums_(state.sums),
      counts_(state.counts) {}

StatusOr<FieldTraining> FieldTraining::Create(
    const Scene& scene,
    const FieldTrainingOptions& options,
    uint64_t seed,
    FieldState state,
    ThreadPool& pool) {
  FREEGS_RETURN_IF_ERROR(options.Check());
  const size_t views = scene.weights.num_views();
  const size_t size = scene.model.size() * state.dim();
  if (views == 0 || scene.views.size() != views ||
      scene.grids.grids.size() != views || scene.guides.size() != views) {
    return InvalidArgumentError(
        "a field is trained with features, guides and weights of the same "
        "views");
  }
  if (state.features.size() != size ||
      state.feature_adam.first_moments.size() != size ||
      state.feature_adam.second_moments.size() != size ||
      state.decoder.feature_dim() != scene.grids.axes.dim ||
      (!state.teachers.labels.empty() &&
       state.teachers.labels.size() != scene.model.size())) {
    return InvalidArgumentError(
        "the state of a field belongs to another scene");
  }
  ArrayAdamState decoder_adam = std::move(state.decoder_adam);
  FieldTraining training(scene, options, seed, std::move(state));
  FREEGS_RETURN_IF_ERROR(
      training.decoder_training_.set_adam(std::move(decoder_adam)));
  if (options.smoothing_weight > 0) {
    FREEGS_ASSIGN_OR_RETURN(
        training.neighbors_,
        BuildNeighborTable(
            scene.model.means, options.smoothing.num_neighbours, pool));
  }
  if (!training.teachers_.labels.empty()) training.ShowTeachers(pool);
  return training;
}

bool FieldTraining::finished() const {
  return step_ >= options_.iterations ||
         (rounds_.size() > 1 && rounds_.back().step == step_ &&
          rounds_.back().agreement >= options_.settled_index);
}

bool FieldTraining::clusters_next() const {
  return options_.cluster_start > 0 && step_ >= options_.cluster_start &&
         step_ < options_.iterations &&
         (step_ - options_.cluster_start) % options_.cluster_interval == 0 &&
         (rounds_.empty() || rounds_.back().step < step_);
}

Status FieldTraining::Teach(InstanceTeachers teachers, ThreadPool& pool) {
  if (teachers.labels.size() != scene_.model.size()) {
    return InvalidArgumentError("instances of another scene's Gaussians");
  }
  ClusteringRound round{step_, teachers.num_instances, 0};
  if (!rounds_.empty()) {
    FREEGS_ASSIGN_OR_RETURN(
        round.agreement, AdjustedRandIndex(teachers_.labels, teachers.labels));
  }
  rounds_.push_back(round);
  teachers_ = std::move(teachers);
  ShowTeachers(pool);
  return Status();
}

// Finds which instances have a vector, and where they are in each view.
void FieldTraining::ShowTeachers(ThreadPool& pool) {
  const size_t dim = scene_.grids.axes.dim;
  known_.assign(teachers_.num_instances, 0);
  for (size_t k = 0; k < known_.size(); ++k) {
    const auto row = std::span(teachers_.vectors).subspan(k * dim, dim);
    known_[k] = std::any_of(
        row.begin(), row.end(), [](float value) { return value != 0; });
  }
  instance_maps_.clear();
  for (size_t view = 0; view < scene_.views.size(); ++view) {
    instance_maps_.push_back(
        splat::RenderLabels(scene_.model,
                            scene_.weights.camera(view),
                            scene_.views[view].cam_from_world,
                            scene_.render,
                            pool,
                            teachers_.labels));
  }
}

FieldState FieldTraining::state() const {
  return {.step = step_,
          .features = features_,
          .feature_adam = feature_adam_,
          .decoder = *decoder_,
          .decoder_adam = decoder_training_.adam(),
          .teachers = teachers_,
          .rounds = rounds_,
          .history = history_,
          .sums = sums_,
          .counts = counts_};
}

void FieldTraining::RecordLosses() {
  history_.push_back({step_,
                      {Mean(sums_.pixel, counts_.pixel),
                       Mean(sums_.instance, counts_.instance),
                       Mean(sums_.smoothing, counts_.smoothing),
                       Mean(sums_.contrastive, counts_.contrastive)}});
  sums_ = counts_ = FieldLosses();
}

StatusOr<FieldTraining::Batch> FieldTraining::Sample(
    const splat::WeightMatrix& weights, ThreadPool& pool) {
  Batch batch;
  batch.view = order_.ViewOf(step_);
  batch.rows.resize(options_.pixels_per_step);
  const uint64_t stream = MixBits(kPixelStream ^ static_cast<uint64_t>(step_));
  for (size_t k = 0; k < batch.rows.size(); ++k) {
    batch.rows[k] = static_cast<uint32_t>(
        RandomIndex(seed_, stream, k, weights.num_pixels()));
  }
  const int dim = decoder_->latent_dim();
  batch.latents.resize(batch.rows.size() * dim);
  FREEGS_RETURN_IF_ERROR(splat::MultiplyAt(
      weights, batch.rows, features_, dim, pool, batch.latents));
  if (!instance_maps_.empty()) {
    for (const uint32_t row : batch.rows) {
      batch.instances.push_back(instance_maps_[batch.view].data()[row]);
    }
  }
  return batch;
}

StatusOr<std::vector<float>> FieldTraining::PixelTargets(
    const Batch& batch, ThreadPool& pool) const {
  const ImageF& guide = scene_.guides[batch.view];
  std::vector<PixelIndex> pixels;
  for (const uint32_t row : batch.rows) {
    pixels.push_back({static_cast<int>(row) % guide.width(),
                      static_cast<int>(row) / guide.width()});
  }
  FREEGS_ASSIGN_OR_RETURN(
      const std::vector<float> coordinates,
      UpsampleViewAt(
          scene_.grids, batch.view, guide, pixels, scene_.upsampling, pool));
  return ExpandFromAxes(scene_.grids.axes, coordinates, pool);
}

Status FieldTraining::Distil(const Batch& batch, ThreadPool& pool) {
  const int channels = decoder_->feature_dim();
  FREEGS_ASSIGN_OR_RETURN(const std::span<const float> decoded,
                          decoder_training_.Forward(batch.latents, pool));
  FREEGS_ASSIGN_OR_RETURN(const std::vector<float> targets,
                          PixelTargets(batch, pool));
  std::vector<float> gradients(decoded.size(), 0.0f);
  FREEGS_ASSIGN_OR_RETURN(
      const double pixel,
      PixelDistillationLoss(decoded, targets, channels, 1.0, pool, gradients));
  Count(pixel, &sums_.pixel, &counts_.pixel);
  if (options_.instance_weight > 0 && !batch.instances.empty()) {
    FREEGS_ASSIGN_OR_RETURN(
        const double instance,
        InstanceDistillationLoss(decoded,
                                 channels,
                                 batch.instances,
                                 {teachers_.vectors, known_},
                                 options_.instance_weight,
                                 pool,
                                 gradients));
    Count(instance, &sums_.instance, &counts_.instance);
  }
  return decoder_training_.Backward(gradients, pool, latent_gradients_);
}

Status FieldTraining::Contrast(const Batch& batch, ThreadPool& pool) {
  const auto dim = static_cast<size_t>(decoder_->latent_dim());
  const auto count = kContrastiveGaussians;
  const uint64_t stream =
      MixBits(kGaussianStream ^ static_cast<uint64_t>(step_));
  std::vector<uint32_t> rows(count);
  std::vector<int32_t> groups(count);
  std::vector<float> features(count * dim);
  std::vector<float> gradients(count * dim, 0.0f);
  for (size_t k = 0; k < count; ++k) {
    rows[k] = static_cast<uint32_t>(
        RandomIndex(seed_, stream, k, scene_.model.size()));
    groups[k] = teachers_.labels[rows[k]];
    std::copy_n(features_.data() + rows[k] * dim, dim, &features[k * dim]);
  }
  FREEGS_ASSIGN_OR_RETURN(
      const double loss,
      JointContrastiveLoss(options_.contrastive,
                           static_cast<int>(dim),
                           {features, groups, gradients},
                           {batch.latents, batch.instances, latent_gradients_},
                           options_.contrastive_weight,
                           pool));
  for (size_t k = 0; k < count; ++k) {
    for (size_t c = 0; c < dim; ++c) {
      feature_gradients_[rows[k] * dim + c] += gradients[k * dim + c];
    }
  }
  Count(loss, &sums_.contrastive, &counts_.contrastive);
  return Status();
}

Status FieldTraining::Smooth(ThreadPool& pool) {
  const std::vector<uint32_t> samples =
      SampleForSmoothing(options_.smoothing, scene_.model.size(), seed_, step_);
  FREEGS_ASSIGN_OR_RETURN(const double loss,
                          SmoothingLoss(features_,
                                        decoder_->latent_dim(),
                                        neighbors_,
                                        samples,
                                        options_.smoothing_weight,
                                        pool,
                                        feature_gradients_));
  Count(loss, &sums_.smoothing, &counts_.smoothing);
  return Status();
}

Status FieldTraining::Step(ThreadPool& pool) {
  FREEGS_ASSIGN_OR_RETURN(const ViewWeights weights,
                          scene_.weights.Weights(order_.ViewOf(step_), pool));
  FREEGS_ASSIGN_OR_RETURN(const Batch batch, Sample(weights.matrix(), pool));
  latent_gradients_.assign(batch.latents.size(), 0.0f);
  feature_gradients_.assign(features_.size(), 0.0f);

  FREEGS_RETURN_IF_ERROR(Distil(batch, pool));
  const bool slow_step = step_ % kSlowInterval == 0;
  if (slow_step && options_.contrastive_weight > 0 &&
      !batch.instances.empty()) {
    FREEGS_RETURN_IF_ERROR(Contrast(batch, pool));
  }
  if (slow_step && options_.smoothing_weight > 0 &&
      step_ >= options_.smoothing_start) {
    FREEGS_RETURN_IF_ERROR(Smooth(pool));
  }
  FREEGS_RETURN_IF_ERROR(splat::AddMultiplyTransposedAt(weights.matrix(),
                                                        batch.rows,
                                                        latent_gradients_,
                                                        decoder_->latent_dim(),
                                                        pool,
                                                        feature_gradients_));
  if (!AllFinite(feature_gradients_)) {
    return UnusableResultError(
        "the semantic field's gradients are not finite "
        "at step " +
        std::to_string(step_));
  }
  FREEGS_RETURN_IF_ERROR(decoder_training_.Step(pool));
  StepArrayAdam(splat::AdamOptions(),
                options_.learning_rate,
                feature_gradients_,
                pool,
                &feature_adam_,
                features_);
  ++step_;
  if (step_ % kStepsPerRecord == 0 || step_ == options_.iterations) {
    RecordLosses();
  }
  return Status();
}

}  // namespace freegs::semantics
