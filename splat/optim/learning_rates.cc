// SPDX-License-Identifier: BSD-3-Clause

#include "splat/optim/learning_rates.h"

#include <algorithm>
#include <cmath>

namespace freegs::splat {

Status LearningRateOptions::Check() const {
  for (const double rate : {mean_initial, mean_final}) {
    if (!(rate > 0 && std::isfinite(rate))) {
      return InvalidArgumentError("the position's learning rates must be > 0");
    }
  }
  for (const double rate :
       {log_scale, rotation, opacity_logit, sh_dc, sh_rest}) {
    if (!(rate >= 0 && std::isfinite(rate))) {
      return InvalidArgumentError("learning rates must be >= 0");
    }
  }
  if (mean_decay_steps < 1) {
    return InvalidArgumentError("mean_decay_steps must be >= 1");
  }
  return Status();
}

LearningRates LearningRatesAt(const LearningRateOptions& options,
                              double scene_extent,
                              double iteration) {
  const double t = std::clamp(iteration / options.mean_decay_steps, 0.0, 1.0);
  const double mean = std::exp((1 - t) * std::log(options.mean_initial) +
                               t * std::log(options.mean_final));
  LearningRates rates;
  const auto set = [&](Parameter parameter, double rate) {
    rates[static_cast<int>(parameter)] = static_cast<float>(rate);
  };
  set(Parameter::kMean, mean * scene_extent);
  set(Parameter::kLogScale, options.log_scale);
  set(Parameter::kRotation, options.rotation);
  set(Parameter::kOpacityLogit, options.opacity_logit);
  set(Parameter::kShDc, options.sh_dc);
  set(Parameter::kShRest, options.sh_rest);
  return rates;
}

}  // namespace freegs::splat
