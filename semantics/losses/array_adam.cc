// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/losses/array_adam.h"

#include <array>

#include "splat/optim/adam_simd.h"

namespace freegs::semantics {
namespace {

constexpr int64_t kGrain = 16384;

}  // namespace

void StepArrayAdam(const splat::AdamOptions& options,
                   double rate,
                   std::span<const float> gradients,
                   ThreadPool& pool,
                   ArrayAdamState* state,
                   std::span<float> parameters) {
  ++state->steps;
  const splat::AdamCoefficients coefficients =
      splat::CoefficientsAt(options, state->steps, rate);
  // For UpdateAdamArray a piece of the array is one group of parameters.
  constexpr std::array<uint32_t, 1> kFirst = {0};
  pool.ParallelFor(0,
                   static_cast<int64_t>(parameters.size()),
                   kGrain,
                   [&](int64_t first, int64_t last, int) {
                     splat::UpdateAdamArray(
                         coefficients,
                         kFirst,
                         splat::GradientRows::kByIndex,
                         static_cast<int>(last - first),
                         gradients.data() + first,
                         state->first_moments.data() + first,
                         state->second_moments.data() + first,
                         parameters.data() + first);
                   });
}

}  // namespace freegs::semantics
