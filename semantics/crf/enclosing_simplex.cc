// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/crf/enclosing_simplex.h"

#include <algorithm>
#include <cmath>

namespace freegs::semantics {
namespace {

// Faster than std::lround, and than std::floor without SSE 4.1, which are
// function calls.
int32_t RoundToNearest(double value) {
  const double shifted = value + 0.5;
  const auto truncated = static_cast<int32_t>(shifted);
  return truncated - (shifted < truncated ? 1 : 0);
}

}  // namespace

SimplexLocator::SimplexLocator(int dim) : dim_(dim), scale_() {
  // Variance per axis in the hyperplane: (d + 1)^2 / 2 from blurring, since the
  // d + 1 unit directions form a tight frame, and (d + 1)^2 / 12 from each of
  // splat and slice; 2/3 (d + 1)^2 together.
  const double deviation = std::sqrt(2.0 / 3.0) * (dim + 1);
  for (int j = 1; j <= dim; ++j) {
    // Basis vector j is (1, .. j times .., 1, -j, 0, .., 0), normalised.
    scale_[j - 1] = deviation / std::sqrt(static_cast<double>(j) * (j + 1));
  }
}

void SimplexLocator::Elevate(const float* feature, double* elevated) const {
  double sum = 0;  // Over the leading ones of the basis vectors.
  for (int j = dim_; j >= 1; --j) {
    const double coordinate = feature[j - 1] * scale_[j - 1];
    elevated[j] = sum - j * coordinate;
    sum += coordinate;
  }
  elevated[0] = sum;
}

void SimplexLocator::Locate(const float* feature,
                            EnclosingSimplex* simplex) const {
  const int d = dim_;
  double elevated[kMaxLatticeDim + 1];
  Elevate(feature, elevated);

  // Round each coordinate to a multiple of d + 1. The sum of these may differ
  // from zero.
  double beyond[kMaxLatticeDim + 1];
  int excess = 0;
  for (int i = 0; i <= d; ++i) {
    const int32_t multiple = RoundToNearest(elevated[i] / (d + 1));
    simplex->origin[i] = multiple * (d + 1);
    beyond[i] = elevated[i] - simplex->origin[i];
    excess += multiple;
  }
  // Equal distances rank in the order of coordinates, so that ranks are a
  // permutation.
  std::fill(simplex->rank.begin(), simplex->rank.begin() + d + 1, 0);
  for (int i = 0; i < d; ++i) {
    for (int j = i + 1; j <= d; ++j) {
      const bool j_first = beyond[i] < beyond[j];
      simplex->rank[i] += j_first ? 1 : 0;
      simplex->rank[j] += j_first ? 0 : 1;
    }
  }
  // Move back to the hyperplane by the coordinates that were rounded most. If
  // the sum is too large, the last ones go down; if it is too small, the first
  // ones go up. Their ranks change with them.
  for (int i = 0; i <= d; ++i) {
    int32_t rank = simplex->rank[i] + excess;
    int32_t step = 0;
    if (rank < 0) step = d + 1;
    if (rank > d) step = -(d + 1);
    simplex->rank[i] = rank + step;
    simplex->origin[i] += step;
    beyond[i] -= step;
  }
  // Barycentric coordinates are differences of successive sorted distances.
  double weights[kMaxLatticeDim + 2] = {};
  for (int i = 0; i <= d; ++i) {
    const double delta = beyond[i] / (d + 1);
    weights[d - simplex->rank[i]] += delta;
    weights[d + 1 - simplex->rank[i]] -= delta;
  }
  weights[0] += 1.0 + weights[d + 1];
  for (int k = 0; k <= d; ++k) {
    // Rounding may make a weight negative.
    simplex->weights[k] = std::max(0.0, weights[k]);
  }
}

}  // namespace freegs::semantics
