// SPDX-License-Identifier: BSD-3-Clause
// A FeatureDecoder while it and the latents are learnt.

#ifndef FREEGS_SEMANTICS_LOSSES_DECODER_TRAINING_H_
#define FREEGS_SEMANTICS_LOSSES_DECODER_TRAINING_H_

#include <span>
#include <vector>

#include "core/parallel.h"
#include "core/status.h"
#include "semantics/losses/array_adam.h"
#include "semantics/losses/feature_decoder.h"
#include "semantics/losses/mlp_gradients.h"
#include "splat/optim/adam.h"

namespace freegs::semantics {

struct DecoderTrainingOptions {
  double learning_rate = 1e-4;  // FreeGS, "CNN layers".

  Status Check() const;
};

// Per step: Forward, the losses on its features, Backward, Step. A linear
// decoder takes part all the same: gradients go through it to the latents, and
// Step changes nothing.
class DecoderTraining {
 public:
  // Keeps a reference to the decoder, which must outlive this.
  DecoderTraining(const DecoderTrainingOptions& options,
                  FeatureDecoder* decoder);

  // The features (S x C) of a batch of latents (S x D), valid until the next
  // call. The MLP normalises with the statistics of the batch, and takes them
  // into its running ones. kInvalidArgument for a size that is no multiple of D
  // and, from the MLP, for latents that are not finite; the decoder is then as
  // before.
  StatusOr<std::span<const float>> Forward(std::span<const float> latents,
                                           ThreadPool& pool);

  // Given dL/dfeatures of the batch of the last Forward, adds dL/dlatents, and
  // dL/dparameters to what the next Step takes. kInvalidArgument for other
  // sizes than the batch's.
  Status Backward(std::span<const float> feature_gradients,
                  ThreadPool& pool,
                  std::span<float> latent_gradients);

  // One step of Adam over the decoder's parameters, with the gradients added
  // since the last. kUnusableResult when they are not finite, or beyond 1e18:
  // they are then forgotten, and the decoder is as before.
  Status Step(ThreadPool& pool);

  // To go on where another left off; of no size for a linear decoder.
  const ArrayAdamState& adam() const { return adam_; }
  // kInvalidArgument for one of another size.
  Status set_adam(ArrayAdamState state);

 private:
  DecoderTrainingOptions options_;
  FeatureDecoder* decoder_;
  MlpBatch batch_;
  std::vector<float> features_;   // S x C, of the last Forward.
  std::vector<float> gradients_;  // Of the parameters.
  ArrayAdamState adam_;
};

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_LOSSES_DECODER_TRAINING_H_
