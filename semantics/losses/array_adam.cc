// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/losses/array_adam.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "splat/optim/adam_simd.h"

namespace freegs::semantics {
namespace {

constexpr int64_t kGrain = 16384;

// What a double counts exactly; more than anyone takes.
constexpr int64_t kMaxSteps = int64_t{1} << 53;

}  // namespace

bool ArrayAdamState::InRange() const {
  return steps >= 0 && steps <= kMaxSteps &&
         std::ranges::all_of(first_moments,
                             [](float m) { return std::isfinite(m); }) &&
         std::ranges::all_of(second_moments, [](float v) {
           return v >= 0 && std::isfinite(v);
         });
}

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
