// SPDX-License-Identifier: BSD-3-Clause

#include <cmath>
#include <numbers>

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include "core/random.h"
#include "splat/projection/spherical_harmonics-inl.h"
#include "splat/scene/gaussian_model.h"

namespace freegs::splat {

using HWY_NAMESPACE::BackwardShBasis;
using HWY_NAMESPACE::EvaluateShBasis;
namespace {

class ShDegree : public testing::TestWithParam<int> {};

TEST_P(ShDegree, BackwardMatchesJets) {
  using Jet = ceres::Jet<double, 3>;
  const int degree = GetParam();
  const int count = NumShCoefficients(degree) - 1;
  RandomStream random(3, degree);
  for (int trial = 0; trial < 50; ++trial) {
    double p[3];
    for (double& v : p) v = random.Normal();
    double weights[15];
    for (double& w : weights) w = random.Normal();
    Jet basis[15];
    EvaluateShBasis(degree, Jet(p[0], 0), Jet(p[1], 1), Jet(p[2], 2), basis);
    Jet value(0.0);
    for (int k = 0; k < count; ++k) value += weights[k] * basis[k];
    double d[3] = {0, 0, 0};
    BackwardShBasis(degree, p[0], p[1], p[2], weights, &d[0], &d[1], &d[2]);
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(d[i], value.v[i], 1e-10);
  }
}

INSTANTIATE_TEST_SUITE_P(All, ShDegree, testing::Values(0, 1, 2, 3));

// The basis is orthonormal over the sphere (with degree 0).
TEST(SphericalHarmonics, TheBasisIsOrthonormal) {
  double gram[16][16] = {};
  const int steps = 200;
  for (int i = 0; i < steps; ++i) {
    const double z = -1 + 2 * (i + 0.5) / steps;
    const double radius = std::sqrt(1 - z * z);
    for (int j = 0; j < steps; ++j) {
      const double phi = 2 * std::numbers::pi * j / steps;
      double basis[16];
      basis[0] = kShC0;
      EvaluateShBasis(
          3, radius * std::cos(phi), radius * std::sin(phi), z, basis + 1);
      const double area = 4 * std::numbers::pi / (steps * steps);
      for (int a = 0; a < 16; ++a) {
        for (int b = 0; b < 16; ++b) gram[a][b] += area * basis[a] * basis[b];
      }
    }
  }
  for (int a = 0; a < 16; ++a) {
    for (int b = 0; b < 16; ++b) {
      EXPECT_NEAR(gram[a][b], a == b ? 1 : 0, 1e-3) << a << ' ' << b;
    }
  }
}

}  // namespace
}  // namespace freegs::splat
