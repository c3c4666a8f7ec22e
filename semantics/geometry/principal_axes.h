// SPDX-License-Identifier: BSD-3-Clause
// The directions in which vectors vary most (principal component analysis).

#ifndef FREEGS_SEMANTICS_GEOMETRY_PRINCIPAL_AXES_H_
#define FREEGS_SEMANTICS_GEOMETRY_PRINCIPAL_AXES_H_

#include <cstddef>
#include <span>
#include <vector>

#include "core/parallel.h"
#include "core/status.h"

namespace freegs::semantics {

struct PrincipalAxes {
  int dim = 0;    // C, of the vectors.
  int count = 0;  // K, of the axes.

  // The vectors' mean, or zero where axes go through the origin; C numbers.
  std::vector<float> mean;

  // Orthonormal, K x C, row-major, by descending energy. The sign of an axis is
  // the one that makes its component of largest magnitude positive.
  std::vector<float> axes;

  // Mean square of the vectors along each of all C axes, descending.
  std::vector<double> energies;

  // Drops all axes but the first `first` of them.
  void Keep(int first);
};

// All C axes of `rows`, N x C, row-major: about their mean, or, for vectors
// whose inner products are to be kept, about the origin. Sums of products are
// in float within 1024 rows, in double beyond. The same bytes for any number of
// threads. kInvalidArgument without rows and for values that are not finite.
StatusOr<PrincipalAxes> ComputePrincipalAxes(std::span<const float> rows,
                                             int dim,
                                             bool about_mean,
                                             ThreadPool& pool);

// How many axes, from 1 to max_count, keep `share` of the energy of all but the
// first `skipped`: the axis of what all vectors have in common tells nothing
// apart.
int AxesForEnergy(std::span<const double> energies,
                  int skipped,
                  double share,
                  int max_count);

// (row - mean) . axis of each row and axis: N x K, row-major. The rows' size is
// a multiple of C.
std::vector<float> ProjectOntoAxes(const PrincipalAxes& axes,
                                   std::span<const float> rows,
                                   ThreadPool& pool);

// mean + sum of coordinate times axis: N x C of N x K coordinates.
std::vector<float> ExpandFromAxes(const PrincipalAxes& axes,
                                  std::span<const float> coordinates,
                                  ThreadPool& pool);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_GEOMETRY_PRINCIPAL_AXES_H_
