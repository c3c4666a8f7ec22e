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

Eigen::Matrix3d NearestRotation(const Eigen::Matrix3d& matrix) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(
      matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d signs(1, 1, 1);
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0) {
    signs.z() = -1;
  }
  return svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
}

}  // namespace freegs
