// SPDX-License-Identifier: BSD-3-Clause

#include "core/decompositions.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/SVD>

namespace freegs {

SymmetricEigen3 DecomposeSymmetric(const Eigen::Matrix3d& matrix) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(matrix);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

Eigen::Vector3d SingularValues(const Eigen::Matrix3d& matrix) {
  return Eigen::JacobiSVD<Eigen::Matrix3d>(matrix).singularValues();
}

SingularValues3 DecomposeSingular(const Eigen::Matrix3d& matrix) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(
      matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return {svd.matrixU(), svd.singularValues(), svd.matrixV()};
}

Eigen::Matrix3d NearestRotation(const Eigen::Matrix3d& matrix) {
  const SingularValues3 svd = DecomposeSingular(matrix);
  Eigen::Vector3d signs(1, 1, 1);
  if (svd.u.determinant() * svd.v.determinant() < 0) signs.z() = -1;
  return svd.u * signs.asDiagonal() * svd.v.transpose();
}

}  // namespace freegs
