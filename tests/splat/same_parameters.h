// SPDX-License-Identifier: BSD-3-Clause
// Whether two models are the same to the last bit.

#ifndef FREEGS_TESTS_SPLAT_SAME_PARAMETERS_H_
#define FREEGS_TESTS_SPLAT_SAME_PARAMETERS_H_

#include "splat/scene/gaussian_model.h"

namespace freegs::splat {

inline bool SameParameters(const GaussianModel& a, const GaussianModel& b) {
  if (a.sh_degree != b.sh_degree) return false;
  for (const Parameter parameter : kAllParameters) {
    if (ParameterArray(a, parameter) != ParameterArray(b, parameter)) {
      return false;
    }
  }
  return true;
}

}  // namespace freegs::splat

#endif  // FREEGS_TESTS_SPLAT_SAME_PARAMETERS_H_
