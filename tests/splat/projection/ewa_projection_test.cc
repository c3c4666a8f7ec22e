// SPDX-License-Identifier: BSD-3-Clause

#include <algorithm>
#include <array>
#include <cmath>

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include "core/random.h"
#include "splat/projection/ewa_projection-inl.h"
#include "splat/projection/projection.h"
#include "tests/splat/test_scene.h"

namespace freegs::splat {

using HWY_NAMESPACE::BackwardProjectGaussian;
using HWY_NAMESPACE::LogOpacityFilter;
using HWY_NAMESPACE::ProjectGaussian;
namespace {

constexpr int kInputs = 10;  // Mean, log scale, rotation.
using Jet = ceres::Jet<double, kInputs>;

template <typename T>
ProjectionCamera<T> Camera(const ProjectionCamera<double>& from) {
  ProjectionCamera<T> to;
  for (int i = 0; i < 9; ++i) to.rotation[i] = T(from.rotation[i]);
  for (int i = 0; i < 3; ++i) {
    to.translation[i] = T(from.translation[i]);
    to.centre[i] = T(from.centre[i]);
  }
  to.fx = T(from.fx), to.fy = T(from.fy), to.cx = T(from.cx),
  to.cy = T(from.cy);
  to.min_u = T(from.min_u), to.max_u = T(from.max_u);
  to.min_v = T(from.min_v), to.max_v = T(from.max_v);
  to.near_plane = T(from.near_plane), to.dilation = T(from.dilation);
  return to;
}

// Adds a pixel to the second moments: q, which is dL/dln(alpha), and the offset
// from the mean.
void AddMoments(const ProjectedGaussian<double>& projected,
                double q,
                double dx,
                double dy,
                double moments[3]) {
  const double sheared = dx + projected.shear * dy;
  moments[0] += q * sheared * sheared;
  moments[1] += q * sheared * dy;
  moments[2] += q * dy * dy;
}

// The hand-written derivative of a random linear functional of the projection,
// against Ceres Jets, for Gaussians inside and far off the image. Sigma'^-1 is
// in it as in a rendering: by the exponents of a few pixels.
TEST(EwaProjection, BackwardMatchesJets) {
  const auto camera = MakeProjectionCamera<double>(
      TestCamera(160, 120), TestPose(), RenderOptions());
  const ProjectionCamera<Jet> jet_camera = Camera<Jet>(camera);
  RandomStream random(7, 1);
  int checked = 0, bounded = 0;
  for (int trial = 0; trial < 300; ++trial) {
    std::array<double, kInputs> input;
    for (int i = 0; i < 3; ++i) {
      input[i] = (trial % 3 == 0 ? 6.0 : 2.0) * (random.Uniform() - 0.5);
    }
    for (int i = 3; i < 6; ++i) input[i] = -4 + 3 * random.Uniform();
    for (int i = 6; i < 10; ++i) input[i] = random.Normal();
    std::array<Jet, kInputs> jets;
    for (int i = 0; i < kInputs; ++i) jets[i] = Jet(input[i], i);

    ProjectedGaussian<double> projected;
    ProjectionTerms<double> terms;
    ProjectedGaussian<Jet> jet_projected;
    ProjectionTerms<Jet> jet_terms;
    const bool visible = ProjectGaussian(
        camera, &input[0], &input[3], &input[6], &projected, &terms);
    ASSERT_EQ(visible,
              ProjectGaussian(jet_camera,
                              &jets[0],
                              &jets[3],
                              &jets[6],
                              &jet_projected,
                              &jet_terms));
    if (!visible) continue;
    ++checked;
    bounded += !terms.u_free || !terms.v_free;

    ProjectedGradient<double> weights{};
    for (double& w : weights.mean) w = random.Normal();
    weights.depth = random.Normal();
    Jet value = weights.depth * jet_projected.depth;
    for (int i = 0; i < 2; ++i)
      value += weights.mean[i] * jet_projected.mean[i];
    for (int pixel = 0; pixel < 3; ++pixel) {
      const double pull = random.Normal();
      const double dx = random.Normal(), dy = random.Normal();
      AddMoments(projected, pull, dx, dy, weights.moments);
      const Jet sheared = dx + jet_projected.shear * dy;
      value -= 0.5 * pull *
               (jet_projected.conic_xx * sheared * sheared +
                jet_projected.precision_y * dy * dy);
    }
    std::array<double, kInputs> gradient{};
    BackwardProjectGaussian(camera,
                            projected,
                            terms,
                            weights,
                            &gradient[0],
                            &gradient[3],
                            &gradient[6]);
    const double scale = value.v.norm();
    for (int i = 0; i < kInputs; ++i) {
      EXPECT_NEAR(gradient[i], value.v[i], 1e-9 * scale + 1e-12)
          << "input " << i;
    }
  }
  EXPECT_GT(checked, 150);
  EXPECT_GT(bounded, 20);
}

// A Gaussian, projected in numbers of type T.
template <typename T>
struct Projected {
  ProjectionCamera<T> camera;
  ProjectedGaussian<T> image;
  ProjectionTerms<T> terms;
  bool visible = false;

  Projected(const ProjectionCamera<double>& exact_camera,
            const std::array<double, kInputs>& input)
      : camera(Camera<T>(exact_camera)) {
    std::array<T, kInputs> numbers;
    for (int i = 0; i < kInputs; ++i) numbers[i] = static_cast<T>(input[i]);
    visible = ProjectGaussian(
        camera, &numbers[0], &numbers[3], &numbers[6], &image, &terms);
  }

  std::array<T, kInputs> Backward(const ProjectedGradient<T>& gradient) const {
    std::array<T, kInputs> result{};
    BackwardProjectGaussian(
        camera, image, terms, gradient, &result[0], &result[3], &result[6]);
    return result;
  }
};

// Where a Gaussian lies and what shape it has: input of ProjectGaussian. In the
// tests below its image is 20 pixels long or more and a pixel wide.
std::array<double, kInputs> LongAndThin(double max_log_scale,
                                        RandomStream& random) {
  std::array<double, kInputs> input;
  input[0] = 0.1 * (random.Uniform() - 0.5);
  input[1] = 0.1 * (random.Uniform() - 0.5);
  input[2] = 0.25;
  input[3] = -3.5 + (max_log_scale + 3.5) * random.Uniform();
  for (int i = 4; i < 6; ++i) {
    input[i] = std::log(1e-4 + 1e-3 * random.Uniform());
  }
  for (int i = 6; i < 10; ++i) input[i] = random.Normal();
  for (double& value : input) value = static_cast<float>(value);
  return input;
}

// In floats the images of Gaussians right in front of the camera are as thin as
// in doubles, however long they are.
TEST(EwaProjection, LongAndThinInFloats) {
  const auto camera = MakeProjectionCamera<double>(
      TestCamera(160, 120), Rigid3d(), RenderOptions());
  RandomStream random(9, 1);
  for (int trial = 0; trial < 200; ++trial) {
    const std::array<double, kInputs> input = LongAndThin(3.5, random);
    const Projected<double> exact(camera, input);
    const Projected<float> projected(camera, input);
    ASSERT_TRUE(exact.visible && projected.visible);
    const double length = std::sqrt(exact.image.cov[0] + exact.image.cov[2]);
    EXPECT_NEAR(projected.image.conic_xx,
                exact.image.conic_xx,
                2e-4 * exact.image.conic_xx)
        << length;
    EXPECT_NEAR(projected.image.precision_y,
                exact.image.precision_y,
                1e-4 * exact.image.precision_y)
        << length;
  }
}

// The derivatives as well. The moments are those of a loss which pulls at
// pixels within the image of the Gaussian.
TEST(EwaProjection, BackwardOfLongAndThinInFloats) {
  const auto camera = MakeProjectionCamera<double>(
      TestCamera(160, 120), Rigid3d(), RenderOptions());
  RandomStream random(10, 1);
  for (int trial = 0; trial < 200; ++trial) {
    const std::array<double, kInputs> input = LongAndThin(1, random);
    const Projected<double> exact(camera, input);
    const Projected<float> projected(camera, input);
    ASSERT_TRUE(exact.visible && projected.visible);
    const double length = std::sqrt(exact.image.cov[0] + exact.image.cov[2]);
    const double along[2] = {
        std::sqrt(exact.image.cov[0]) / length,
        std::copysign(std::sqrt(exact.image.cov[2]) / length,
                      exact.image.cov[1])};
    ProjectedGradient<double> weights{};
    for (int pixel = 0; pixel < 20; ++pixel) {
      const double l = length * random.Normal(), t = random.Normal();
      const double dx = l * along[0] - t * along[1];
      const double dy = l * along[1] + t * along[0];
      const double pull = random.Uniform();
      AddMoments(exact.image, pull, dx, dy, weights.moments);
    }
    ProjectedGradient<float> float_weights{};
    for (int k = 0; k < 3; ++k) {
      float_weights.moments[k] = static_cast<float>(weights.moments[k]);
      weights.moments[k] = float_weights.moments[k];
    }
    const auto want = exact.Backward(weights);
    const auto got = projected.Backward(float_weights);
    EXPECT_NEAR(got[3], want[3], 1e-3 * std::abs(want[3])) << length;
    double size = 0;
    for (int i = 6; i < 10; ++i) size = std::max(size, std::abs(want[i]));
    for (int i = 6; i < 10; ++i) {
      EXPECT_NEAR(got[i], want[i], 0.02 * size) << length;
    }
  }
}

TEST(EwaProjection, SmallIsotropicGaussianOnTheAxis) {
  ProjectionCamera<double> camera = MakeProjectionCamera<double>(
      {100, 80, 50, 60, 50, 40}, Rigid3d(), RenderOptions());
  const double mean[3] = {0, 0, 2};
  const double s = std::log(0.1);
  const double log_scale[3] = {s, s, s};
  const double rotation[4] = {0.3, -2, 0.5, 1};
  ProjectedGaussian<double> projected;
  ProjectionTerms<double> terms;
  ASSERT_TRUE(
      ProjectGaussian(camera, mean, log_scale, rotation, &projected, &terms));
  EXPECT_DOUBLE_EQ(projected.mean[0], 50);
  EXPECT_DOUBLE_EQ(projected.mean[1], 40);
  EXPECT_DOUBLE_EQ(projected.depth, 2);
  // Standard deviation f s / z, plus the low-pass filter.
  EXPECT_NEAR(projected.cov[0], std::pow(50 * 0.1 / 2, 2) + 0.3, 1e-9);
  EXPECT_NEAR(projected.cov[2], std::pow(60 * 0.1 / 2, 2) + 0.3, 1e-9);
  EXPECT_NEAR(projected.cov[1], 0, 1e-9);
}

TEST(EwaProjection, RejectsWhatCannotBeSeen) {
  const ProjectionCamera<float> camera = MakeProjectionCamera<float>(
      {100, 80, 50, 60, 50, 40}, Rigid3d(), RenderOptions());
  ProjectedGaussian<float> projected;
  ProjectionTerms<float> terms;
  const float unit[4] = {1, 0, 0, 0};
  const float zero_rotation[4] = {0, 0, 0, 0};
  const float small[3] = {-3, -3, -3};
  const float huge[3] = {80, 80, 80};
  const float nan[3] = {NAN, 0, 0};
  const float front[3] = {0, 0, 2};
  const float behind[3] = {0, 0, -2};
  const float at_centre[3] = {0, 0, 0};
  const auto project = [&](const float* mean, const float* s, const float* q) {
    return ProjectGaussian(camera, mean, s, q, &projected, &terms);
  };
  EXPECT_TRUE(project(front, small, unit));
  EXPECT_FALSE(project(behind, small, unit));
  EXPECT_FALSE(project(at_centre, small, unit));
  EXPECT_FALSE(project(front, small, zero_rotation));
  EXPECT_FALSE(project(front, huge, unit));
  EXPECT_FALSE(project(front, nan, unit));
}

// The factor of the opacity and its derivative, against Ceres Jets, for
// Gaussians from a hundredth of a pixel to many pixels.
TEST(EwaProjection, FilterMatchesJets) {
  const auto camera = MakeProjectionCamera<double>(
      TestCamera(160, 120), TestPose(), RenderOptions());
  const ProjectionCamera<Jet> jet_camera = Camera<Jet>(camera);
  RandomStream random(8, 1);
  int checked = 0, bounded = 0;
  for (int trial = 0; trial < 300; ++trial) {
    std::array<double, kInputs> input;
    for (int i = 0; i < 3; ++i) input[i] = 2 * (random.Uniform() - 0.5);
    const double size = -9 + 7 * random.Uniform();
    for (int i = 3; i < 6; ++i) input[i] = size + random.Uniform();
    for (int i = 6; i < 10; ++i) input[i] = random.Normal();
    std::array<Jet, kInputs> jets;
    for (int i = 0; i < kInputs; ++i) jets[i] = Jet(input[i], i);

    ProjectedGaussian<double> projected;
    ProjectionTerms<double> terms;
    ProjectedGaussian<Jet> jet_projected;
    ProjectionTerms<Jet> jet_terms;
    if (!ProjectGaussian(
            camera, &input[0], &input[3], &input[6], &projected, &terms)) {
      continue;
    }
    ProjectGaussian(
        jet_camera, &jets[0], &jets[3], &jets[6], &jet_projected, &jet_terms);
    const double filter = LogOpacityFilter(terms);
    const Jet expected = LogOpacityFilter(jet_terms);
    EXPECT_NEAR(filter, expected.a, 1e-12);
    EXPECT_LE(filter, 0);
    ++checked;
    bounded += expected.v.isZero();
    ProjectedGradient<double> gradient{};
    gradient.log_filter = 1;
    std::array<double, kInputs> found{};
    BackwardProjectGaussian(
        camera, projected, terms, gradient, &found[0], &found[3], &found[6]);
    const double scale = expected.v.cwiseAbs().maxCoeff();
    for (int i = 0; i < kInputs; ++i) {
      EXPECT_NEAR(found[i], expected.v[i], 1e-6 * scale + 1e-12) << i;
    }
  }
  EXPECT_GT(checked, 200);
  EXPECT_GT(bounded, 5);
  EXPECT_LT(bounded, 100);
}

// The gradient of the filter is right in floats, too, for images 0.03 to 0.33
// pixels wide and 10 to 300 long. What alpha at the pixels pulls at log scales
// is of order 1.
TEST(EwaProjection, FilterOfLongAndThinInFloats) {
  const auto camera = MakeProjectionCamera<double>(
      TestCamera(1600, 1200), Rigid3d(), RenderOptions());
  RandomStream random(12, 1);
  for (int trial = 0; trial < 300; ++trial) {
    std::array<double, kInputs> input;
    input[0] = random.Uniform() - 0.5;
    input[1] = random.Uniform() - 0.5;
    input[2] = 1 + 4 * random.Uniform();
    const double pixel = std::log(input[2] / camera.fx);
    input[3] = std::log(10 + 290 * random.Uniform()) + pixel;
    input[4] = std::log(0.03 + 0.3 * random.Uniform()) + pixel;
    input[5] = std::log(0.03) + pixel;
    for (int i = 6; i < 10; ++i) input[i] = random.Normal();
    for (double& value : input) value = static_cast<float>(value);
    const Projected<double> exact(camera, input);
    const Projected<float> projected(camera, input);
    ASSERT_TRUE(exact.visible && projected.visible);
    EXPECT_NEAR(
        LogOpacityFilter(projected.terms), LogOpacityFilter(exact.terms), 1e-3);
    ProjectedGradient<double> gradient{};
    gradient.log_filter = 1;
    ProjectedGradient<float> float_gradient{};
    float_gradient.log_filter = 1;
    const auto want = exact.Backward(gradient);
    const auto got = projected.Backward(float_gradient);
    // A turn of the unnormalised quaternion has the size 1 / |q|.
    const double turn = std::max(1.0, exact.terms.inverse_norm);
    for (int i = 3; i < kInputs; ++i) {
      EXPECT_NEAR(got[i], want[i], i < 6 ? 1e-3 : 3e-3 * turn) << "input " << i;
    }
  }
}

}  // namespace
}  // namespace freegs::splat
