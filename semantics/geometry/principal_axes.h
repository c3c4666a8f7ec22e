// SPDX-License-Identifier: BSD-3-Clause
// Principal component analysis: the directions in which vectors vary most.

#ifndef FREEGS_SEMANTICS_GEOMETRY_PRINCIPAL_AXES_H_
#define FREEGS_SEMANTICS_GEOMETRY_PRINCIPAL_AXES_H_

#include <cstddef>
#include <span>
#include <vector>

#include "core/parallel.h"
#include "core/status.h"

namespace freegs::semantics {

struct PrincipalAxes {
  int dim = 0;    // C: numbers per vector.
  int count = 0;  // K: number of axes.

  // C numbers: the mean of the vectors, or zero if the axes go through the
  // origin.
  std::vector<float> mean;

  // K x C, row-major: orthonormal rows by descending energy. The sign of a row
  // makes its component of largest magnitude positive.
  std::vector<float> axes;

  // The mean square of the vectors along each of all C axes, descending. Keep()
  // does not shorten it.
  std::vector<double> energies;

  // Drops all axes but the first `first`.
  void Keep(int first);
};

// Returns all C axes of `rows`, N x C. about_mean: true takes the axes about
// the mean of the rows; false takes them about the origin, which keeps inner
// products. Products are summed in float within 1024 rows, and in double
// beyond. The result has the same bytes for any number of threads.
// kInvalidArgument for no rows and for values that are not finite.
StatusOr<PrincipalAxes> ComputePrincipalAxes(std::span<const float> rows,
                                             int dim,
                                             bool about_mean,
                                             ThreadPool& pool);

// Returns how many axes hold `share` of the energy, but at least 1 and at most
// max_count. If more are needed, max_count is returned, and those hold less.
// The first `skipped` axes do not count as energy: an axis along which all
// vectors are alike tells nothing apart.
int AxesForEnergy(std::span<const double> energies,
                  int skipped,
                  double share,
                  int max_count);

// Returns (row - mean) . axis for each row and axis, N x K. The size of `rows`
// is a multiple of C.
std::vector<float> ProjectOntoAxes(const PrincipalAxes& axes,
                                   std::span<const float> rows,
                                   ThreadPool& pool);

// The way back: returns mean + sum of coordinate * axis, N x C, for N x K
// coordinates.
std::vector<float> ExpandFromAxes(const PrincipalAxes& axes,
                                  std::span<const float> coordinates,
                                  ThreadPool& pool);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_GEOMETRY_PRINCIPAL_AXES_H_
