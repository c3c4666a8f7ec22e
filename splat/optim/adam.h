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
#include "splat/scene/gaussian_model.h"
#include "splat/optim/learning_rates.h"

namespace freegs::splat {

struct AdamOptions {
  // Decay per step of the first and second moments.
  double beta1 = 0.9;
  double beta2 = 0.999;

  // Added to the root of the second moment (1e-15 in 3DGS).
  double epsilon = 1e-15;

  Status Check() const;
};

// The constants of step t = 1, 2, ... at the learning rate `rate`.
AdamCoefficients CoefficientsAt(const AdamOptions& options,
                                int64_t step,
                                double rate);

// What Adam remembers; moments have the shapes of the model.
struct AdamState {
  int64_t steps = 0;
  GaussianModel first_moments;
  GaussianModel second_moments;
};

// Sparse Adam: only Gaussians that a step touched move. For the others neither
// the moments decay nor does momentum carry the parameters on, while the bias
// correction counts all steps. Dense Adam would move Gaussians in views that
// cannot see them; on the touched ones both agree when every step touches them.
class Adam {
 public:
  explicit Adam(const AdamOptions& options = {}) : options_(options) {}

  // Zero moments of the shapes of `model`, zero steps.
  void Reset(const GaussianModel& model);

  // One step. `gradients` has the model's shapes and is read at `touched` only
  // (ascending, without repeats, each below model->size()). Runs of consecutive
  // indices go through SIMD. The same bytes for any number of threads.
  void Step(const LearningRates& rates,
            const GaussianGradients& gradients,
            std::span<const uint32_t> touched,
            ThreadPool& pool,
            GaussianModel* model);

  // The same step in parts, for gradients that never are in one array:
  // BeginStep once, then UpdateRows for every touched Gaussian once. Row j of
  // `rows` belongs to Gaussian touched[j]. Concurrent calls may not share
  // Gaussians.
  void BeginStep(const LearningRates& rates);
  void UpdateRows(std::span<const uint32_t> touched,
                  const GaussianGradients& rows,
                  GaussianModel* model);

  // Follow the model's own edits: keep the Gaussians listed (same lists as
  // GaussianModel::Select), append `count` with zero moments, or change the
  // stored SH degree.
  void Select(std::span<const uint32_t> indices);
  void Append(size_t count);
  void SetShDegree(int degree);

  // Forgets the moments of one kind of parameter.
  void ZeroMoments(Parameter parameter);

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
  // Of the step begun last.
  std::array<AdamCoefficients, kNumParameters> coefficients_;
};

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_OPTIM_ADAM_H_
