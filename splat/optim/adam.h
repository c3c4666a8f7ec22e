// SPDX-License-Identifier: BSD-3-Clause
// Adam (Kingma and Ba 2015) over the parameters of a Gaussian model.

#ifndef FREEGS_SPLAT_OPTIM_ADAM_H_
#define FREEGS_SPLAT_OPTIM_ADAM_H_

#include <array>
#include <cstdint>
#include <span>

#include "core/parallel.h"
#include "core/status.h"
#include "splat/optim/adam_simd.h"
#include "splat/optim/learning_rates.h"
#include "splat/scene/gaussian_model.h"

namespace freegs::splat {

struct AdamOptions {
  // Factors by which the first and second moments decay per step.
  double beta1 = 0.9;
  double beta2 = 0.999;

  // Added to the square root of the second moment; 1e-15 as in 3DGS.
  double epsilon = 1e-15;

  Status Check() const;
};

// The constants of step number `step` = 1, 2, ... at the learning rate `rate`.
AdamCoefficients CoefficientsAt(const AdamOptions& options,
                                int64_t step,
                                double rate);

// What Adam keeps from step to step. The moments have the shapes of the model.
struct AdamState {
  int64_t steps = 0;
  GaussianModel first_moments;
  GaussianModel second_moments;
};

// Sparse Adam: a step changes the parameters and moments of the Gaussians it
// touched, and nothing else. Dense Adam would also move Gaussians that the view
// of the step does not show, by their momentum. The bias correction counts all
// steps, so a Gaussian that every step touches moves as with dense Adam.
//
//   Adam adam;
//   adam.Reset(model);
//   adam.Step(LearningRatesAt({}, scene_extent, 0), gradients, visible, pool,
//             &model);
class Adam {
 public:
  explicit Adam(const AdamOptions& options = {}) : options_(options) {}

  // Begins anew: moments of zero in the shapes of `model`, and no steps.
  void Reset(const GaussianModel& model);

  // Makes one step. `gradients` has the model's shapes; only the Gaussians in
  // `touched` (ascending, without repeats, each below model->size()) are read
  // and changed. The result is the same bytes for any number of threads.
  void Step(const LearningRates& rates,
            const GaussianGradients& gradients,
            std::span<const uint32_t> touched,
            ThreadPool& pool,
            GaussianModel* model);

  // BeginStep and UpdateRows make the step of Step in parts, for gradients that
  // are computed in chunks. Call BeginStep once, then UpdateRows so that it
  // gets every touched Gaussian once. Row j of `rows` belongs to Gaussian
  // touched[j]. Several threads may call UpdateRows at the same time for
  // different Gaussians.
  void BeginStep(const LearningRates& rates);
  void UpdateRows(std::span<const uint32_t> touched,
                  const GaussianGradients& rows,
                  GaussianModel* model);

  // To be called whenever the model changes in the same way, so that the
  // moments keep its shapes: keep the Gaussians listed (see
  // GaussianModel::Select), append `count` Gaussians with moments of zero,
  // change the SH degree.
  void Select(std::span<const uint32_t> indices);
  void Append(size_t count);
  void SetShDegree(int degree);

  size_t size() const { return state_.first_moments.size(); }
  const AdamState& state() const { return state_; }
  void set_state(AdamState state) { state_ = std::move(state); }

 private:
  void Update(std::span<const uint32_t> touched,
              GradientRows rows,
              const GaussianGradients& gradients,
              GaussianModel* model);

  AdamOptions options_;
  AdamState state_;
  // The constants of the step that was begun last, by kind of parameter.
  std::array<AdamCoefficients, kNumParameters> coefficients_;
};

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_OPTIM_ADAM_H_
