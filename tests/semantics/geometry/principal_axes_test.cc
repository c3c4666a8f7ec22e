// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/geometry/principal_axes.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "core/random.h"

namespace freegs::semantics {
namespace {

// Points that vary by 3 along (0.6, 0.8, 0), by 1 along (-0.8, 0.6, 0), and by
// 0.1 along z, about (5, -2, 1).
std::vector<float> Ellipsoid(int count) {
  RandomStream random(1, 2);
  std::vector<float> rows;
  for (int i = 0; i < count; ++i) {
    const double a = 3 * random.Normal();
    const double b = random.Normal();
    rows.push_back(static_cast<float>(5 + 0.6 * a - 0.8 * b));
    rows.push_back(static_cast<float>(-2 + 0.8 * a + 0.6 * b));
    rows.push_back(static_cast<float>(1 + 0.1 * random.Normal()));
  }
  return rows;
}

TEST(PrincipalAxesTest, FindsTheAxesOfAnEllipsoid) {
  ThreadPool pool(2);
  const auto axes = ComputePrincipalAxes(Ellipsoid(20000), 3, true, pool);
  ASSERT_TRUE(axes.ok());
  EXPECT_NEAR(axes->energies[0], 9, 0.3);
  EXPECT_NEAR(axes->energies[1], 1, 0.05);
  EXPECT_NEAR(axes->energies[2], 0.01, 0.001);
  EXPECT_NEAR(axes->axes[0], 0.6, 0.02);
  EXPECT_NEAR(axes->axes[1], 0.8, 0.02);
  EXPECT_NEAR(axes->axes[3], 0.8, 0.02);  // The sign of the largest.
  EXPECT_NEAR(axes->mean[1], -2, 0.1);
}

TEST(PrincipalAxesTest, AboutTheOriginTheFirstAxisIsWhatIsCommon) {
  ThreadPool pool(1);
  const std::vector<float> rows = {10, 1, 10, -1, 10, 0};
  const auto axes = ComputePrincipalAxes(rows, 2, false, pool);
  ASSERT_TRUE(axes.ok());
  EXPECT_NEAR(axes->axes[0], 1, 1e-6);
  EXPECT_NEAR(axes->energies[0], 100, 1e-4);
  EXPECT_EQ(axes->mean[0], 0);
}

TEST(PrincipalAxesTest, ProjectingAndExpandingLosesOnlyWhatWasDropped) {
  ThreadPool pool(3);
  const std::vector<float> rows = Ellipsoid(3000);
  auto axes = ComputePrincipalAxes(rows, 3, true, pool);
  ASSERT_TRUE(axes.ok());
  axes->Keep(2);
  const std::vector<float> back =
      ExpandFromAxes(*axes, ProjectOntoAxes(*axes, rows, pool), pool);
  double lost = 0;
  for (size_t i = 0; i < rows.size(); ++i) {
    lost += (rows[i] - back[i]) * (rows[i] - back[i]);
  }
  EXPECT_NEAR(lost / 3000, axes->energies[2], 1e-4);
}

TEST(PrincipalAxesTest, CountsTheAxesThatKeepEnergy) {
  const std::vector<double> energies = {100, 6, 3, 1};
  EXPECT_EQ(AxesForEnergy(energies, 0, 0.9, 4), 1);
  EXPECT_EQ(AxesForEnergy(energies, 1, 0.6, 4), 2);
  EXPECT_EQ(AxesForEnergy(energies, 1, 0.9, 4), 3);
  EXPECT_EQ(AxesForEnergy(energies, 1, 1.0, 4), 4);
  // No more than asked for, although they hold less than the share.
  EXPECT_EQ(AxesForEnergy(energies, 1, 0.9, 2), 2);
  EXPECT_EQ(AxesForEnergy(energies, 1, 1.0, 2), 2);
  EXPECT_EQ(AxesForEnergy(std::vector<double>{0, 0}, 0, 0.9, 8), 1);
}

TEST(PrincipalAxesTest, SameBytesForAnyNumberOfThreads) {
  std::vector<float> rows(2500 * 70);
  for (size_t i = 0; i < rows.size(); ++i) {
    rows[i] = static_cast<float>(RandomNormal(3, 4, i));
  }
  ThreadPool one(1);
  ThreadPool three(3);
  const auto a = ComputePrincipalAxes(rows, 70, true, one);
  const auto b = ComputePrincipalAxes(rows, 70, true, three);
  ASSERT_TRUE(a.ok() && b.ok());
  EXPECT_EQ(a->axes, b->axes);
  EXPECT_EQ(ProjectOntoAxes(*a, rows, one), ProjectOntoAxes(*b, rows, three));
}

TEST(PrincipalAxesTest, RefusesWhatHasNoAxes) {
  ThreadPool pool(1);
  EXPECT_EQ(ComputePrincipalAxes({}, 3, true, pool).status().code(),
            StatusCode::kInvalidArgument);
  const std::vector<float> four(4, 1.0f);
  EXPECT_FALSE(ComputePrincipalAxes(four, 3, true, pool).ok());
  const std::vector<float> nan(3, std::numeric_limits<float>::quiet_NaN());
  EXPECT_FALSE(ComputePrincipalAxes(nan, 3, true, pool).ok());
  // All equal: axes, of no energy.
  const auto same = ComputePrincipalAxes(four, 2, true, pool);
  ASSERT_TRUE(same.ok());
  EXPECT_EQ(same->energies[0], 0);
}

}  // namespace
}  // namespace freegs::semantics
