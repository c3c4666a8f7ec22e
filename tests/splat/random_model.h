// SPDX-License-Identifier: BSD-3-Clause
// Models with random parameters, for tests.

#ifndef FREEGS_TESTS_SPLAT_RANDOM_MODEL_H_
#define FREEGS_TESTS_SPLAT_RANDOM_MODEL_H_

#include <cstddef>
#include <cstdint>

#include "core/random.h"
#include "splat/scene/gaussian_model.h"
#include "tests/splat/same_parameters.h"

namespace freegs::splat {

// Every parameter uniform in [-scale, scale].
inline GaussianModel RandomModel(size_t count,
                                 int sh_degree,
                                 uint64_t seed,
                                 double scale = 1.0) {
  GaussianModel model;
  model.sh_degree = sh_degree;
  model.Resize(count);
  for (const Parameter parameter : kAllParameters) {
    std::vector<float>& array = ParameterArray(model, parameter);
    for (size_t i = 0; i < array.size(); ++i) {
      array[i] = static_cast<float>(
          scale *
          (2 * RandomUniform(seed, static_cast<uint64_t>(parameter), i) - 1));
    }
  }
  return model;
}

}  // namespace freegs::splat

#endif  // FREEGS_TESTS_SPLAT_RANDOM_MODEL_H_
