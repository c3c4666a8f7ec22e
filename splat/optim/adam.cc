// SPDX-License-Identifier: BSD-3-Clause

#include "splat/optim/adam.h"

#include <cmath>

namespace freegs::splat {
namespace {

// How many touched Gaussians a task updates.
constexpr int64_t kGrain = 2048;

}  // namespace

Status AdamOptions::Check() const {
  for (const double beta : {beta1, beta2}) {
    if (!(beta >= 0 && beta < 1)) {
      return InvalidArgumentError("Adam's decays must be in [0, 1)");
    }
  }
  if (!(epsilon > 0 && std::isfinite(epsilon))) {
    return InvalidArgumentError("Adam's epsilon must be > 0");
  }
  return Status();
}

AdamCoefficients CoefficientsAt(const AdamOptions& options,
                                int64_t step,
                                double rate) {
  const auto t = static_cast<double>(step);
  const double correction1 = 1 - std::pow(options.beta1, t);
  const double correction2 = 1 - std::pow(options.beta2, t);
  AdamCoefficients coefficients;
  coefficients.one_minus_beta1 = static_cast<float>(1 - options.beta1);
  coefficients.beta2 = static_cast<float>(options.beta2);
  coefficients.one_minus_beta2 = static_cast<float>(1 - options.beta2);
  coefficients.step_size = static_cast<float>(rate / correction1);
  coefficients.root_correction = static_cast<float>(1 / std::sqrt(correction2));
  coefficients.epsilon = static_cast<float>(options.epsilon);
  return coefficients;
}

void Adam::Reset(const GaussianModel& model) {
  state_ = AdamState();
  for (GaussianModel* moments :
       {&state_.first_moments, &state_.second_moments}) {
    moments->sh_degree = model.sh_degree;
    moments->Resize(model.size());
  }
}

void Adam::BeginStep(const LearningRates& rates) {
  ++state_.steps;
  for (int kind = 0; kind < kNumParameters; ++kind) {
    coefficients_[kind] = CoefficientsAt(options_, state_.steps, rates[kind]);
  }
}

void Adam::Step(const LearningRates& rates,
                const GaussianGradients& gradients,
                std::span<const uint32_t> touched,
                ThreadPool& pool,
                GaussianModel* model) {
  BeginStep(rates);
  pool.ParallelFor(0,
                   static_cast<int64_t>(touched.size()),
                   kGrain,
                   [&](int64_t first, int64_t last, int) {
                     Update(touched.subspan(first, last - first),
                            GradientRows::kByIndex,
                            gradients,
                            model);
                   });
}

void Adam::UpdateRows(std::span<const uint32_t> touched,
                      const GaussianGradients& rows,
                      GaussianModel* model) {
  Update(touched, GradientRows::kByPlace, rows, model);
}

void Adam::Update(std::span<const uint32_t> touched,
                  GradientRows rows,
                  const GaussianGradients& gradients,
                  GaussianModel* model) {
  for (const Parameter parameter : kAllParameters) {
    UpdateAdamArray(coefficients_[static_cast<int>(parameter)],
                    touched,
                    rows,
                    ParameterStride(*model, parameter),
                    ParameterArray(gradients, parameter).data(),
                    ParameterArray(state_.first_moments, parameter).data(),
                    ParameterArray(state_.second_moments, parameter).data(),
                    ParameterArray(*model, parameter).data());
  }
}

void Adam::Select(std::span<const uint32_t> indices) {
  state_.first_moments.Select(indices);
  state_.second_moments.Select(indices);
}

void Adam::Append(size_t count) {
  const size_t total = size() + count;
  state_.first_moments.Resize(total);
  state_.second_moments.Resize(total);
}

void Adam::SetShDegree(int degree) {
  state_.first_moments.SetShDegree(degree);
  state_.second_moments.SetShDegree(degree);
}

}  // namespace freegs::splat
