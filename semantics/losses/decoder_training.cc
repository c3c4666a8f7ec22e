// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/losses/decoder_training.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>

namespace freegs::semantics {
namespace {

// The square of a gradient must fit in a float.
constexpr float kMaxGradient = 1e18f;
// The weight of a batch in the running statistics, which decode after training.
constexpr double kStatisticsMomentum = 0.1;

}  // namespace

Status DecoderTrainingOptions::Check() const {
  if (!(learning_rate >= 0 && std::isfinite(learning_rate))) {
    return InvalidArgumentError("the decoder's learning rate must be >= 0");
  }
  return Status();
}

DecoderTraining::DecoderTraining(const DecoderTrainingOptions& options,
                                 FeatureDecoder* decoder)
    : options_(options), decoder_(decoder) {
  const size_t size =
      decoder->mlp() ? decoder->mlp()->shape.num_parameters() : 0;
  gradients_.assign(size, 0.0f);
  adam_ = ArrayAdamState::OfSize(size);
}

StatusOr<std::span<const float>> DecoderTraining::Forward(
    std::span<const float> latents, ThreadPool& pool) {
  const auto dim = static_cast<size_t>(decoder_->latent_dim());
  if (latents.size() % dim != 0) {
    return InvalidArgumentError(std::to_string(latents.size()) +
                                " latents, no multiple of " +
                                std::to_string(dim));
  }
  features_.resize(latents.size() / dim * decoder_->feature_dim());
  if (MlpDecoder* mlp = decoder_->mlp()) {
    MlpForward(*mlp, latents, pool, &batch_, features_);
    if (!batch_.statistics_finite()) {
      return InvalidArgumentError(
          "latents to decode are not finite or too large");
    }
    UpdateRunningStatistics(batch_, kStatisticsMomentum, mlp);
  } else {
    FREEGS_RETURN_IF_ERROR(decoder_->Decode(latents, pool, features_));
  }
  return std::span<const float>(features_);
}

Status DecoderTraining::Backward(std::span<const float> feature_gradients,
                                 ThreadPool& pool,
                                 std::span<float> latent_gradients) {
  const size_t rows = features_.size() / decoder_->feature_dim();
  if (feature_gradients.size() != features_.size() ||
      latent_gradients.size() != rows * decoder_->latent_dim()) {
    return InvalidArgumentError(
        std::to_string(feature_gradients.size()) + " gradients of features, " +
        std::to_string(latent_gradients.size()) +
        " of latents, of a batch of " + std::to_string(rows) + " rows");
  }
  if (const MlpDecoder* mlp = decoder_->mlp()) {
    MlpBackward(
        *mlp, batch_, feature_gradients, pool, gradients_, latent_gradients);
  } else {
    AddLinearGradients(
        *decoder_->linear(), feature_gradients, pool, latent_gradients);
  }
  return Status();
}

Status DecoderTraining::Step(ThreadPool& pool) {
  MlpDecoder* mlp = decoder_->mlp();
  if (!mlp) return Status();
  const bool usable =
      std::all_of(gradients_.begin(), gradients_.end(), [](float value) {
        return std::abs(value) <= kMaxGradient;
      });
  if (usable) {
    StepArrayAdam({.epsilon = 1e-8},
                  options_.learning_rate,
                  gradients_,
                  pool,
                  &adam_,
                  mlp->parameters);
  }
  std::fill(gradients_.begin(), gradients_.end(), 0.0f);
  return usable
             ? Status()
             : UnusableResultError(
                   "the gradients of the decoder are not finite or too large");
}

Status DecoderTraining::set_adam(ArrayAdamState state) {
  if (state.first_moments.size() != gradients_.size() ||
      state.second_moments.size() != gradients_.size()) {
    return InvalidArgumentError(
        "Adam's state is of another decoder than the one trained");
  }
  adam_ = std::move(state);
  return Status();
}

}  // namespace freegs::semantics
