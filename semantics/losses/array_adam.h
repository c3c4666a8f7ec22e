// SPDX-License-Identifier: BSD-3-Clause
// Adam (Kingma and Ba 2015) over one array of parameters, all of which move in
// every step. splat/optim/adam.h is the one for Gaussian models, where only the
// Gaussians in sight move.

#ifndef FREEGS_SEMANTICS_LOSSES_ARRAY_ADAM_H_
#define FREEGS_SEMANTICS_LOSSES_ARRAY_ADAM_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/parallel.h"
#include "splat/optim/adam.h"

namespace freegs::semantics {

// What Adam remembers. The moments have the size of the parameters.
struct ArrayAdamState {
  int64_t steps = 0;
  std::vector<float> first_moments;
  std::vector<float> second_moments;

  // The state before the first step.
  static ArrayAdamState OfSize(size_t size) {
    return {0, std::vector<float>(size, 0.0f), std::vector<float>(size, 0.0f)};
  }

  // Whether these can be Adam's numbers: no fewer than 0 steps and no more than
  // a double counts exactly, finite moments, and second ones of at least 0.
  bool InRange() const;
};

// Takes one step with learning rate `rate`. All arrays have the same size. The
// result has the same bytes for any number of threads.
void StepArrayAdam(const splat::AdamOptions& options,
                   double rate,
                   std::span<const float> gradients,
                   ThreadPool& pool,
                   ArrayAdamState* state,
                   std::span<float> parameters);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_LOSSES_ARRAY_ADAM_H_
