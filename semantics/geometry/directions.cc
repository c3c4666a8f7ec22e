// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/geometry/directions.h"

#include <algorithm>
#include <cmath>

namespace freegs::semantics {
namespace {

// 1 / |v|, or 0 of a vector of no length.
template <typename T>
double InverseLength(std::span<const T> v) {
  double square = 0;
  for (const T x : v) square += double{x} * x;
  return square > 0 ? 1 / std::sqrt(square) : 0;
}

}  // namespace

void AddDirection(std::span<const float> v,
                  double weight,
                  std::span<double> sum) {
  const double scale = weight * InverseLength(v);
  for (size_t c = 0; c < v.size(); ++c) sum[c] += scale * v[c];
}

void WriteDirection(std::span<const double> sum, std::span<float> out) {
  const double scale = InverseLength(sum);
  for (size_t c = 0; c < sum.size(); ++c) {
    out[c] = static_cast<float>(scale * sum[c]);
  }
}

void MakeUnitRows(size_t dim, std::span<float> rows) {
  for (size_t first = 0; first < rows.size(); first += dim) {
    const std::span<float> row = rows.subspan(first, dim);
    const auto scale =
        static_cast<float>(InverseLength(std::span<const float>(row)));
    for (float& x : row) x *= scale;
  }
}

}  // namespace freegs::semantics
