// SPDX-License-Identifier: BSD-3-Clause
// Vectors of which only the direction counts, as features of CLIP are compared.

#ifndef FREEGS_SEMANTICS_GEOMETRY_DIRECTIONS_H_
#define FREEGS_SEMANTICS_GEOMETRY_DIRECTIONS_H_

#include <cstddef>
#include <span>
#include <vector>

namespace freegs::semantics {

// sum += weight v / |v|; nothing of a vector of no length. All of one size.
void AddDirection(std::span<const float> v,
                  double weight,
                  std::span<double> sum);

// out = sum / |sum|, or zero where the sum is.
void WriteDirection(std::span<const double> sum, std::span<float> out);

// Makes rows of `dim` numbers each of length 1; zero rows stay.
void MakeUnitRows(size_t dim, std::span<float> rows);

// Rows of length 1, or zero: `share` of the directions of a's, the rest of b's.
// The same number of rows of `dim` numbers in both.
std::vector<float> MixDirections(std::span<const float> a,
                                 std::span<const float> b,
                                 size_t dim,
                                 double share);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_GEOMETRY_DIRECTIONS_H_
