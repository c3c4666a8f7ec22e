// SPDX-License-Identifier: BSD-3-Clause
// The mean of what a model is at the steps of a training. Each step follows the
// gradient of one photograph, so the parameters move around where all
// photographs together want them. Their mean over the last steps is nearer to
// it than any single step is (Polyak and Juditsky, "Acceleration of stochastic
// approximation by averaging", 1992).

#ifndef FREEGS_SPLAT_OPTIM_MODEL_AVERAGE_H_
#define FREEGS_SPLAT_OPTIM_MODEL_AVERAGE_H_

#include <cstdint>

#include "core/parallel.h"
#include "splat/scene/gaussian_model.h"

namespace freegs::splat {

struct ModelAverage {
  int64_t count = 0;   // Number of models that the mean is of.
  GaussianModel mean;  // Empty when count is 0.

  // Takes another model into the mean of each parameter. Gaussian i must be the
  // same one as before; where their number or the SH degree has changed, the
  // mean begins again with this model. The result is the same for any number of
  // threads.
  void Add(const GaussianModel& model, ThreadPool& pool);

  // Forgets all models. The memory is kept for the next ones.
  void Clear();
};

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_OPTIM_MODEL_AVERAGE_H_
