// SPDX-License-Identifier: BSD-3-Clause
// Sums and mixtures of vectors of which only the direction counts. Features of
// CLIP are such vectors: they are compared by their cosine.

#ifndef FREEGS_SEMANTICS_GEOMETRY_DIRECTIONS_H_
#define FREEGS_SEMANTICS_GEOMETRY_DIRECTIONS_H_

#include <cstddef>
#include <span>
#include <vector>

namespace freegs::semantics {

// Adds weight * v / |v| to `sum`, or nothing if v is zero. Both have the same
// size.
void AddDirection(std::span<const float> v,
                  double weight,
                  std::span<double> sum);

// Writes sum / |sum| to `out`, or zeros if `sum` is zero. Both have the same
// size.
void WriteDirection(std::span<const double> sum, std::span<float> out);

// Scales each row of `dim` numbers to length 1. Rows of zeros stay as they are.
void MakeUnitRows(size_t dim, std::span<float> rows);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_GEOMETRY_DIRECTIONS_H_
