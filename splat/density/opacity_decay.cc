// SPDX-License-Identifier: BSD-3-Clause

#include "splat/density/opacity_decay.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace freegs::splat {
namespace {

// An opacity of 3e-7 is invisible. A long training does not take it further
// down, to where its logarithm is not finite any more.
constexpr double kLeastLogit = -15;

}  // namespace

Status OpacityDecayOptions::Check() const {
  if (!(strength >= 0) || enough_photos < 1 ||
      !(max_share >= 0 && max_share < 1)) {
    return InvalidArgumentError(
        "opacity decay: strength must not be negative, enough_photos must be "
        "positive, max_share from 0 to below 1");
  }
  return Status();
}

double OpacityDecayShare(const OpacityDecayOptions& options,
                         size_t num_photos) {
  const double photos = static_cast<double>(std::max<size_t>(num_photos, 1));
  const double share =
      options.strength * (1 / photos - 1.0 / options.enough_photos);
  return std::clamp(share, 0.0, options.max_share);
}

void DecayOpacity(double share, ThreadPool& pool, GaussianModel* model) {
  constexpr int64_t kGrain = 1 << 12;
  // With opacity o = 1 / (1 + exp(-x)), the logit of (1 - s) o is
  // x + log(1 - s) - log(1 + s exp(x)).
  const double kept = std::log1p(-share);
  pool.ParallelFor(0,
                   static_cast<int64_t>(model->size()),
                   kGrain,
                   [&](int64_t begin, int64_t end, int) {
                     for (int64_t i = begin; i < end; ++i) {
                       const double x = model->opacity_logits[i];
                       if (x <= kLeastLogit) continue;
                       const double less =
                           x + kept - std::log1p(share * std::exp(x));
                       // What is not a number stays so, for the trainer to
                       // notice.
                       model->opacity_logits[i] =
                           static_cast<float>(std::max(less, kLeastLogit));
                     }
                   });
}

}  // namespace freegs::splat
