// SPDX-License-Identifier: BSD-3-Clause
// Hand-written gradients in float against central differences, in double, of
// the formula that they are of.

#ifndef FREEGS_TESTS_SEMANTICS_LOSSES_GRADIENT_CHECK_H_
#define FREEGS_TESTS_SEMANTICS_LOSSES_GRADIENT_CHECK_H_

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include "core/function_ref.h"
#include "core/random.h"

namespace freegs::semantics {

inline std::vector<float> RandomValues(size_t count, uint64_t seed) {
  std::vector<float> values(count);
  for (size_t k = 0; k < count; ++k) {
    values[k] = static_cast<float>(RandomNormal(seed, 7, k));
  }
  return values;
}

inline std::vector<double> ToDouble(std::span<const float> values) {
  return {values.begin(), values.end()};
}

inline std::vector<double> CentralDifferences(
    FunctionRef<double(const std::vector<double>&)> function,
    std::vector<double> at,
    double step = 1e-5) {
  std::vector<double> gradient(at.size());
  for (size_t k = 0; k < at.size(); ++k) {
    const double x = at[k];
    at[k] = x + step;
    const double above = function(at);
    at[k] = x - step;
    const double below = function(at);
    at[k] = x;
    gradient[k] = (above - below) / (2 * step);
  }
  return gradient;
}

// Every number to within `tolerance` times the largest of them: a few float
// roundings of sums of like terms.
inline void ExpectSameGradient(std::span<const float> analytic,
                               const std::vector<double>& numeric,
                               double tolerance = 1e-5) {
  ASSERT_EQ(analytic.size(), numeric.size());
  double largest = 0;
  for (const double g : numeric) largest = std::max(largest, std::abs(g));
  ASSERT_GT(largest, 0);
  for (size_t k = 0; k < numeric.size(); ++k) {
    ASSERT_NEAR(analytic[k], numeric[k], tolerance * largest) << k;
  }
}

inline bool AllZero(std::span<const float> values) {
  return std::all_of(
      values.begin(), values.end(), [](float value) { return value == 0; });
}

}  // namespace freegs::semantics

#endif  // FREEGS_TESTS_SEMANTICS_LOSSES_GRADIENT_CHECK_H_
