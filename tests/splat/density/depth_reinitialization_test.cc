// SPDX-License-Identifier: BSD-3-Clause
// Midpoints against a search for the highest density; points on a plane that a
// tilted camera sees, in the colours of their pixels.

#include "splat/density/depth_reinitialization.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "core/random.h"
#include "tests/splat/random_model.h"

namespace freegs::splat {
namespace {

constexpr double kNear = 0.2;
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

GaussianModel OneGaussian(const Eigen::Vector3d& mean,
                          const Eigen::Vector3d& scale,
                          const Eigen::Quaterniond& rotation) {
  GaussianModel model;
  model.Resize(1);
  for (int k = 0; k < 3; ++k) {
    model.means[k] = static_cast<float>(mean[k]);
    model.log_scales[k] = static_cast<float>(std::log(scale[k]));
  }
  model.rotations = {static_cast<float>(rotation.w()),
                     static_cast<float>(rotation.x()),
                     static_cast<float>(rotation.y()),
                     static_cast<float>(rotation.z())};
  return model;
}

// Squared distance from the mean in standard deviations.
double Mahalanobis(const GaussianModel& model,
                   size_t i,
                   const Eigen::Vector3d& point) {
  const float* const q = &model.rotations[4 * i];
  const Eigen::Quaterniond rotation =
      Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized();
  const Eigen::Vector3d offset =
      rotation.conjugate() *
      (point - Eigen::Vector3f(&model.means[3 * i]).cast<double>());
  double sum = 0;
  for (int k = 0; k < 3; ++k) {
    const double scale = std::exp(double{model.log_scales[3 * i + k]});
    sum += offset[k] * offset[k] / (scale * scale);
  }
  return sum;
}

TEST(MidpointDistanceTest, IsWhereTheDensityIsHighest) {
  const GaussianModel model = RandomModel(50, 0, 11);
  RandomStream random(1, 2);
  for (size_t i = 0; i < model.size(); ++i) {
    const Eigen::Vector3d mean =
        Eigen::Vector3f(&model.means[3 * i]).cast<double>();
    Eigen::Vector3d origin;
    Eigen::Vector3d target;
    for (int k = 0; k < 3; ++k) {
      origin[k] = 3 * random.Normal();
      target[k] = mean[k] + 0.3 * random.Normal();
    }
    const Eigen::Vector3d direction = (target - origin).normalized();
    const std::optional<double> found =
        MidpointDistance(model, i, origin, direction);
    ASSERT_TRUE(found.has_value());
    double best = 0;
    double lowest = std::numeric_limits<double>::infinity();
    for (double t = -5; t < 25; t += 1e-3) {
      const double value = Mahalanobis(model, i, origin + t * direction);
      if (value < lowest) {
        lowest = value;
        best = t;
      }
    }
    EXPECT_NEAR(*found, best, 1.1e-3) << i;
    // The middle: as dense on either side.
    EXPECT_NEAR(Mahalanobis(model, i, origin + (*found - 0.5) * direction),
                Mahalanobis(model, i, origin + (*found + 0.5) * direction),
                1e-5 * (1 + lowest))
        << i;
  }
}

TEST(MidpointDistanceTest, FlatOnesAreMetAtTheirPlane) {
  const Eigen::Vector3d origin(0.3, -0.2, -4);
  for (const double thickness : {1e-3, 1e-9, 1e-30}) {
    const GaussianModel model = OneGaussian(
        {0, 0, 1}, {1.0, 2.0, thickness}, Eigen::Quaterniond::Identity());
    const Eigen::Vector3d direction = Eigen::Vector3d(0.1, 0.2, 1).normalized();
    const std::optional<double> t =
        MidpointDistance(model, 0, origin, direction);
    ASSERT_TRUE(t.has_value());
    EXPECT_NEAR((origin + *t * direction).z(), 1.0, 1e-5) << thickness;
  }
}

TEST(MidpointDistanceTest, GrazingRaysStayNearTheMean) {
  // Would meet the plane z = 0 a kilometre behind the disc.
  const GaussianModel disc =
      OneGaussian({0, 0, 0}, {0.1, 0.1, 1e-12}, Eigen::Quaterniond::Identity());
  const Eigen::Vector3d origin(-10, 0, 1.01e-2);
  const Eigen::Vector3d direction = Eigen::Vector3d(1, 0, -1e-5).normalized();
  const std::optional<double> t = MidpointDistance(disc, 0, origin, direction);
  ASSERT_TRUE(t.has_value());
  EXPECT_NEAR(*t, 10.333, 1e-3);
  // Within the plane exactly.
  const std::optional<double> inside =
      MidpointDistance(disc, 0, {-10, 0, 0}, {1, 0, 0});
  ASSERT_TRUE(inside.has_value());
  EXPECT_NEAR(*inside, 10.0, 1e-9);
}

TEST(MidpointDistanceTest, BehindAndBroken) {
  GaussianModel model =
      OneGaussian({0, 0, -2}, {1, 1, 1}, Eigen::Quaterniond::Identity());
  const auto distance = [&] {
    return MidpointDistance(model, 0, {0, 0, 0}, {0, 0, 1});
  };
  ASSERT_TRUE(distance().has_value());
  EXPECT_NEAR(*distance(), -2.0, 1e-6);
  const GaussianModel whole = model;
  for (const float bad : {kNan, std::numeric_limits<float>::infinity()}) {
    model.means[1] = bad;
    EXPECT_FALSE(distance().has_value());
    model = whole;
    model.log_scales[2] = bad;
    EXPECT_FALSE(distance().has_value());
    model = whole;
    model.rotations[0] = bad;
    EXPECT_FALSE(distance().has_value());
    model = whole;
  }
  model.rotations = {0, 0, 0, 0};
  EXPECT_FALSE(distance().has_value());
  model = whole;
  model.log_scales = {200, -200, 0};  // Beyond what floats hold.
  ASSERT_TRUE(distance().has_value());
  EXPECT_TRUE(std::isfinite(*distance()));
}

// A tilted camera that sees one large flat Gaussian, and a photo whose colours
// name their pixel.
struct Plane {
  static constexpr int kWidth = 16;
  static constexpr int kHeight = 12;

  Eigen::Vector3d mean{0.5, -1, 3};
  Eigen::Quaterniond rotation =
      Eigen::Quaterniond(0.9, 0.2, -0.3, 0.1).normalized();
  GaussianModel model = OneGaussian(mean, {5, 5, 1e-9}, rotation);
  View view;
  ViewContributions contributions;
  ImageF photo{kWidth, kHeight, 3};

  Plane() {
    view.camera = {kWidth, kHeight, 20, 21, 8.3, 5.8};
    view.cam_from_world.rotation = Eigen::Quaterniond(
        Eigen::AngleAxisd(0.2, Eigen::Vector3d(1, 2, -1).normalized()));
    view.cam_from_world.translation = {0.1, 0.3, 2};
    contributions.dominant = Image<int32_t>(kWidth, kHeight, 1, 0);
    contributions.transmittance = ImageF(kWidth, kHeight, 1, 0.5f);
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        photo(x, y, 0) = static_cast<float>(x);
        photo(x, y, 1) = static_cast<float>(y);
        photo(x, y, 2) = 0.25f;
      }
    }
  }

  StatusOr<DepthPoints> Sample(size_t count, uint64_t stream = 1) const {
    return SampleDepthPoints(
        model, view, contributions, photo, kNear, count, 1, stream);
  }
};

TEST(SampleDepthPointsTest, PointsLieOnThePlaneUnderTheirPixel) {
  const Plane plane;
  const StatusOr<DepthPoints> points = plane.Sample(100);
  ASSERT_TRUE(points.ok());
  ASSERT_EQ(points->size(), 100u);
  const Eigen::Vector3d normal = plane.rotation * Eigen::Vector3d::UnitZ();
  const Pinhole& camera = plane.view.camera;
  std::set<std::pair<float, float>> pixels;
  for (size_t i = 0; i < points->size(); ++i) {
    EXPECT_NEAR(normal.dot(points->positions[i] - plane.mean), 0.0, 2e-5);
    const Eigen::Vector3d in_camera =
        plane.view.cam_from_world * points->positions[i];
    EXPECT_GT(in_camera.z(), kNear);
    const auto [x, y, blue] = points->colors[i];
    EXPECT_NEAR(
        camera.fx * in_camera.x() / in_camera.z() + camera.cx, x + 0.5, 1e-5);
    EXPECT_NEAR(
        camera.fy * in_camera.y() / in_camera.z() + camera.cy, y + 0.5, 1e-5);
    EXPECT_EQ(blue, 0.25f);
    pixels.insert({x, y});
  }
  EXPECT_EQ(pixels.size(), 100u);  // Without replacement.
}

TEST(SampleDepthPointsTest, RepeatableAndAtMostThePixelsThereAre) {
  const Plane plane;
  EXPECT_EQ(plane.Sample(50)->positions, plane.Sample(50)->positions);
  EXPECT_NE(plane.Sample(50, 1)->positions, plane.Sample(50, 2)->positions);
  EXPECT_EQ(plane.Sample(1000)->size(), 16u * 12u);
  EXPECT_EQ(plane.Sample(0)->size(), 0u);
}

TEST(SampleDepthPointsTest, OpaquePixelsAreDrawnMoreOften) {
  Plane plane;
  for (int y = 0; y < Plane::kHeight; ++y) {
    for (int x = 0; x < Plane::kWidth; ++x) {
      plane.contributions.transmittance(x, y) = x < 8 ? 0.9f : 0.1f;
    }
  }
  double left = 0;
  constexpr int kTrials = 5000;
  for (uint64_t stream = 0; stream < kTrials; ++stream) {
    const StatusOr<DepthPoints> points = plane.Sample(1, stream);
    ASSERT_EQ(points->size(), 1u);
    if (points->colors[0][0] < 8) left += 1;
  }
  EXPECT_NEAR(left / kTrials, 0.1, 4 * std::sqrt(0.1 * 0.9 / kTrials));
}

TEST(SampleDepthPointsTest, LeavesOutPixelsWithoutASurface) {
  Plane plane;
  // In front of the camera, right behind its near plane, and broken.
  plane.model = OneGaussian(
      plane.mean, {1e-3, 1e-3, 1e-3}, Eigen::Quaterniond::Identity());
  const Rigid3d world_from_cam = Inverse(plane.view.cam_from_world);
  for (const double depth : {0.19, 0.21}) {
    plane.model.AppendFrom(
        OneGaussian(world_from_cam * Eigen::Vector3d(0, 0, depth),
                    {1e-4, 1e-4, 1e-4},
                    Eigen::Quaterniond::Identity()),
        0);
  }
  plane.model.AppendFrom(plane.model, 0);
  plane.model.means[9] = kNan;
  Image<int32_t>& dominant = plane.contributions.dominant;
  std::fill(dominant.data(), dominant.data() + dominant.size(), -1);
  EXPECT_EQ(plane.Sample(10)->size(), 0u);
  for (int i = 0; i < 5; ++i) dominant(3 + i, 5) = i;  // 4: not in the model.
  plane.contributions.transmittance(3, 5) = 0.0f;
  ASSERT_EQ(plane.Sample(10)->size(), 2u);
  EXPECT_EQ(plane.Sample(10)->colors[0][0], 3.0f);
  EXPECT_EQ(plane.Sample(10)->colors[1][0], 5.0f);
  plane.contributions.transmittance(5, 5) = 1.0f;
  EXPECT_EQ(plane.Sample(10)->size(), 1u);
}

TEST(SampleDepthPointsTest, EmptyAndMismatchedViews) {
  EXPECT_EQ(SampleDepthPoints({}, {}, {}, ImageF(0, 0, 3), kNear, 5, 1, 1)
                .status()
                .code(),
            StatusCode::kInvalidArgument);
  Plane plane;
  plane.photo = ImageF(Plane::kHeight, Plane::kWidth, 3);
  EXPECT_FALSE(plane.Sample(5).ok());
  plane.photo = ImageF(Plane::kWidth, Plane::kHeight, 1);
  EXPECT_FALSE(plane.Sample(5).ok());
  plane = Plane();
  plane.contributions.transmittance = ImageF();
  EXPECT_FALSE(plane.Sample(5).ok());
  plane = Plane();
  plane.model = GaussianModel();
  EXPECT_EQ(plane.Sample(5)->size(), 0u);
}

TEST(PointsPerViewTest, SharesInProportion) {
  using Counts = std::vector<size_t>;
  using Opacity = std::vector<double>;
  EXPECT_EQ(PointsPerView(Opacity{1, 2, 1}, 8), (Counts{2, 4, 2}));
  EXPECT_EQ(PointsPerView(Opacity{1, 1, 1}, 5), (Counts{2, 2, 1}));
  EXPECT_EQ(PointsPerView(Opacity{1, 5, 4}, 1), (Counts{0, 1, 0}));
  EXPECT_EQ(PointsPerView(Opacity{3}, 7), (Counts{7}));
  EXPECT_EQ(PointsPerView(Opacity{0, kNan, -1, 1}, 3), (Counts{0, 0, 0, 3}));
  EXPECT_EQ(PointsPerView(Opacity{0, 0}, 3), (Counts{0, 0}));
  EXPECT_TRUE(PointsPerView({}, 3).empty());
  Opacity many(997);
  for (size_t i = 0; i < many.size(); ++i) many[i] = RandomUniform(1, 1, i);
  const double sum = std::accumulate(many.begin(), many.end(), 0.0);
  for (const size_t total : {1u, 500u, 3500000u}) {
    const Counts counts = PointsPerView(many, total);
    EXPECT_EQ(std::accumulate(counts.begin(), counts.end(), size_t{0}), total);
    for (size_t i = 0; i < many.size(); ++i) {
      EXPECT_NEAR(static_cast<double>(counts[i]), many[i] / sum * total, 1.0);
    }
  }
}

TEST(AccumulatedOpacityTest, CountsPixelsWithADominantGaussian) {
  EXPECT_EQ(AccumulatedOpacity({}), 0.0);
  ViewContributions contributions;
  contributions.dominant = Image<int32_t>(2, 2, 1, 5);
  contributions.dominant(1, 1) = -1;
  contributions.transmittance = ImageF(2, 2, 1, 0.25f);
  EXPECT_EQ(AccumulatedOpacity(contributions), 2.25);
}

TEST(RestartFromDepthPointsTest, TakesThemAsTheyAre) {
  const Plane plane;
  DepthPoints points = *plane.Sample(20);
  points.Append(*plane.Sample(20, 2));
  ASSERT_EQ(points.size(), 40u);
  for (auto& color : points.colors) color = {0.25f, 1.0f, 0.0f};
  const StatusOr<GaussianModel> model = RestartFromDepthPoints(points, 1.0);
  ASSERT_TRUE(model.ok());
  ASSERT_EQ(model->size(), 40u);
  EXPECT_FLOAT_EQ(kShC0 * model->sh_dc[0] + 0.5f, 0.25f);
  EXPECT_FLOAT_EQ(kShC0 * model->sh_dc[1] + 0.5f, 1.0f);
  // Not quite black, so that it has a gradient.
  EXPECT_NEAR(kShC0 * model->sh_dc[2] + 0.5f, 1 / 255.0f, 1e-6f);
  EXPECT_FLOAT_EQ(model->means[119],
                  static_cast<float>(points.positions[39].z()));
  EXPECT_FALSE(RestartFromDepthPoints({}, 1.0).ok());
}

}  // namespace
}  // namespace freegs::splat
