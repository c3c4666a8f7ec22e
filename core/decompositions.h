// SPDX-License-Identifier: BSD-3-Clause
// Eigen's decompositions of 3 x 3 matrices. They are here, and not in the files
// that need them, because each file that includes Eigen's headers for them
// takes seconds longer to compile.

#ifndef FREEGS_CORE_DECOMPOSITIONS_H_
#define FREEGS_CORE_DECOMPOSITIONS_H_

#include <Eigen/Core>

namespace freegs {

struct SymmetricEigen3 {
  Eigen::Vector3d values;   // Ascending.
  Eigen::Matrix3d vectors;  // Column k is the unit eigenvector of values[k].
};

// Decomposes a symmetric matrix, of which only the lower triangle is read.
SymmetricEigen3 DecomposeSymmetric(const Eigen::Matrix3d& matrix);

// Returns the singular values, the largest first.
Eigen::Vector3d SingularValues(const Eigen::Matrix3d& matrix);

struct SingularValues3 {
  Eigen::Matrix3d u;       // Orthogonal.
  Eigen::Vector3d values;  // The largest first.
  Eigen::Matrix3d v;       // Orthogonal.
};

// Returns the decomposition u diag(values) v^T of the matrix.
SingularValues3 DecomposeSingular(const Eigen::Matrix3d& matrix);

// Returns the rotation R with the largest trace of R^T `matrix`, which is the
// nearest one in the Frobenius norm (Kabsch 1976).
Eigen::Matrix3d NearestRotation(const Eigen::Matrix3d& matrix);

}  // namespace freegs

#endif  // FREEGS_CORE_DECOMPOSITIONS_H_
