// SPDX-License-Identifier: BSD-3-Clause

#include "core/decompositions.h"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <gtest/gtest.h>

namespace freegs {
namespace {

const Eigen::Matrix3d kRotation =
    Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized())
        .toRotationMatrix();

TEST(Decompositions, SymmetricMatrix) {
  const Eigen::Vector3d values(1, 4, 9);
  const SymmetricEigen3 found = DecomposeSymmetric(
      kRotation * values.asDiagonal() * kRotation.transpose());
  EXPECT_TRUE(found.values.isApprox(values, 1e-12));
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(std::abs(found.vectors.col(k).dot(kRotation.col(k))), 1, 1e-12);
  }
}

TEST(Decompositions, SingularValuesAreNotSigned) {
  const Eigen::Matrix3d matrix =
      kRotation * Eigen::Vector3d(-2, 0, 5).asDiagonal();
  EXPECT_TRUE(SingularValues(matrix).isApprox(Eigen::Vector3d(5, 2, 0), 1e-12));
}

TEST(Decompositions, SingularVectors) {
  Eigen::Matrix3d matrix;
  matrix << 1, 2, 3, 4, 5, 6, 7, 8, -10;
  const SingularValues3 found = DecomposeSingular(matrix);
  EXPECT_TRUE(matrix.isApprox(
      found.u * found.values.asDiagonal() * found.v.transpose(), 1e-12));
  EXPECT_TRUE(found.values.isApprox(SingularValues(matrix), 1e-12));
  for (const Eigen::Matrix3d& q : {found.u, found.v}) {
    EXPECT_TRUE((q.transpose() * q).isIdentity(1e-12));
  }
}

TEST(Decompositions, NearestRotation) {
  EXPECT_TRUE(NearestRotation(3 * kRotation).isApprox(kRotation, 1e-12));
  // The nearest orthogonal matrix of a reflection is no rotation.
  const Eigen::Matrix3d nearest =
      NearestRotation(kRotation * Eigen::Vector3d(3, 2, -1).asDiagonal());
  EXPECT_TRUE(nearest.isApprox(kRotation, 1e-12));
  EXPECT_NEAR(nearest.determinant(), 1, 1e-12);
}

}  // namespace
}  // namespace freegs
