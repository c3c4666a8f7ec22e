// SPDX-License-Identifier: BSD-3-Clause
// What the rasterizer makes of long and thin splats.

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include "core/random.h"
#include "splat/projection/ewa_projection-inl.h"
#include "splat/projection/projection.h"
#include "splat/render/rasterizer.h"
#include "tests/splat/reference_renderer.h"
#include "tests/splat/test_scene.h"

namespace freegs::splat {
namespace {

RenderOptions OnBlue() {
  RenderOptions options;
  options.background = {0.2f, 0.5f, 0.9f};
  return options;
}

// Long and thin Gaussians whose means lie up to 20000 pixels outside of the
// picture, into which they reach.
TEST(ThinSplats, SplatsFromFarOutsideAreAsTheyShouldBe) {
  GaussianModel model = RandomSceneModel(20, 0, 8);
  RandomStream random(8, 3);
  for (size_t i = 0; i < model.size(); ++i) {
    const double angle = 6.28 * random.Uniform();
    const double distance = std::exp(4.5 * random.Uniform());
    const double depth = 0.3 + random.Uniform();
    model.means[3 * i] = static_cast<float>(
        0.4 * depth * (random.Uniform() - 0.5) + distance * std::cos(angle));
    model.means[3 * i + 1] = static_cast<float>(
        0.4 * depth * (random.Uniform() - 0.5) + distance * std::sin(angle));
    model.means[3 * i + 2] = static_cast<float>(depth);
    model.log_scales[3 * i] = static_cast<float>(std::log(1.5 * distance));
    model.log_scales[3 * i + 1] = std::log(1e-3f);
    model.log_scales[3 * i + 2] = std::log(1e-3f);
    model.rotations[4 * i] = static_cast<float>(std::cos(angle / 2));
    model.rotations[4 * i + 1] = model.rotations[4 * i + 2] = 0;
    model.rotations[4 * i + 3] = static_cast<float>(std::sin(angle / 2));
    model.opacity_logits[i] = 2;
  }
  const Pinhole camera = TestCamera(75, 53);
  const std::vector<double> expected =
      ReferenceRender(ReferenceModel(model), camera, Rigid3d(), OnBlue());
  ThreadPool pool(2);
  Rasterizer rasterizer;
  RasterImages images;
  rasterizer.Forward(model, camera, Rigid3d(), OnBlue(), {}, pool, &images);
  size_t covered = 0;
  for (size_t p = 0; p < images.color.num_pixels(); ++p) {
    const double* want = &expected[5 * p];
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(images.color.data()[3 * p + c], want[c], 0.02);
    }
    EXPECT_NEAR(images.transmittance.data()[p], want[3], 0.02);
    covered += want[3] < 0.9;
  }
  EXPECT_GT(covered, images.color.num_pixels() / 4);
}

// The gradients of one splat, 1000 pixels long and a pixel wide, against the
// same sums in doubles. L is a random weight of each pixel times its
// transmittance.
TEST(ThinSplats, GradientsOfASplatOfAThousandPixels) {
  const Pinhole camera = TestCamera(1600, 1200);
  RandomStream random(9, 3);
  ImageF weights(camera.width, camera.height, 1);
  for (size_t p = 0; p < weights.num_pixels(); ++p) {
    weights.data()[p] = static_cast<float>(random.Normal());
  }
  GaussianModel model;
  model.Resize(1);
  model.means = {0.02f, -0.01f, 1.0f};
  model.log_scales = {std::log(0.7f), std::log(4e-4f), std::log(6e-4f)};
  model.opacity_logits = {1.0f};
  const auto exact_camera =
      MakeProjectionCamera<double>(camera, Rigid3d(), OnBlue());
  ThreadPool pool(2);
  for (int turn = 0; turn < 6; ++turn) {
    const double angle = 0.06 + 0.52 * turn;
    model.rotations = {static_cast<float>(std::cos(angle / 2)),
                       0.03f,
                       -0.02f,
                       static_cast<float>(std::sin(angle / 2))};
    Rasterizer rasterizer;
    RasterImages images;
    rasterizer.Forward(model, camera, Rigid3d(), OnBlue(), {}, pool, &images);
    GaussianModel got;
    got.Resize(1);
    ImageF no_color(camera.width, camera.height, 3);
    rasterizer.Backward(
        model, {&no_color, &weights, nullptr}, images, pool, &got, {});

    double input[10];
    std::copy_n(model.means.begin(), 3, input);
    std::copy_n(model.log_scales.begin(), 3, input + 3);
    std::copy_n(model.rotations.begin(), 4, input + 6);
    ProjectedGaussian<double> exact;
    ProjectionTerms<double> terms;
    ASSERT_TRUE(HWY_NAMESPACE::ProjectGaussian(
        exact_camera, input, input + 3, input + 6, &exact, &terms));
    ProjectedGradient<double> gradient{};
    const double opacity = 1 / (1 + std::exp(-1.0));
    for (int y = 0; y < camera.height; ++y) {
      for (int x = 0; x < camera.width; ++x) {
        const double dy = y + 0.5 - exact.mean[1];
        const double e = x + 0.5 - exact.mean[0] + exact.shear * dy;
        const double alpha =
            opacity * std::exp(-0.5 * (exact.conic_xx * e * e +
                                       exact.precision_y * dy * dy));
        if (alpha < kMinAlpha) continue;
        const double q = -weights(x, y) * alpha;
        gradient.mean[0] += q * exact.conic_xx * e;
        gradient.mean[1] +=
            q * (exact.conic_xx * exact.shear * e + exact.precision_y * dy);
        gradient.moments[0] += q * e * e;
        gradient.moments[1] += q * e * dy;
        gradient.moments[2] += q * dy * dy;
      }
    }
    double want[10] = {};
    HWY_NAMESPACE::BackwardProjectGaussian(
        exact_camera, exact, terms, gradient, want, want + 3, want + 6);
    const auto check = [&](std::span<const float> values, int first) {
      double size = 0;
      for (size_t i = 0; i < values.size(); ++i) {
        size = std::max(size, std::abs(want[first + i]));
      }
      for (size_t i = 0; i < values.size(); ++i) {
        EXPECT_NEAR(values[i], want[first + i], 5e-3 * size)
            << "angle " << angle << ", parameter " << first + i;
      }
    };
    const std::span<const float> log_scales = got.log_scales;
    check(got.means, 0);
    check(log_scales.first(1), 3);
    check(log_scales.last(2), 4);  // Across: smaller by far.
    check(got.rotations, 6);
  }
}

}  // namespace
}  // namespace freegs::splat
