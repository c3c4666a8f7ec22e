// SPDX-License-Identifier: BSD-3-Clause

#include "splat/optim/model_average.h"

#include <vector>

namespace freegs::splat {

void ModelAverage::Add(const GaussianModel& model, ThreadPool& pool) {
  if (count == 0 || mean.size() != model.size() ||
      mean.sh_degree != model.sh_degree) {
    mean = model;
    count = 1;
    return;
  }
  ++count;
  const float share = 1.0f / static_cast<float>(count);
  constexpr int64_t kGrain = 1 << 14;
  for (const Parameter parameter : kAllParameters) {
    const std::vector<float>& added = ParameterArray(model, parameter);
    std::vector<float>& means = ParameterArray(mean, parameter);
    pool.ParallelFor(0,
                     static_cast<int64_t>(means.size()),
                     kGrain,
                     [&](int64_t begin, int64_t end, int) {
                       for (int64_t i = begin; i < end; ++i) {
                         means[i] += share * (added[i] - means[i]);
                       }
                     });
  }
}

void ModelAverage::Clear() {
  count = 0;
  mean.Resize(0);
}

}  // namespace freegs::splat
