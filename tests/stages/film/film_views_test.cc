// SPDX-License-Identifier: BSD-3-Clause

#include "stages/film/film_views.h"

#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "splat/scene/gaussian_model.h"
#include "stages/film/camera_path.h"

namespace freegs::stages {
namespace {

// Photos on a part of a circle around a point, a little above it.
std::vector<View> PhotosAround(const Eigen::Vector3d& centre,
                               double arc,
                               int count) {
  Orbit orbit;
  orbit.centre = centre;
  orbit.radius = 4;
  orbit.height = 1;
  std::vector<View> photos;
  for (int k = 0; k < count; ++k) {
    orbit.first_azimuth = arc * k / count;
    View view;
    view.name = "photo" + std::to_string(k);
    view.camera = {101, 75, 90, 90, 50, 37};
    view.cam_from_world = OrbitPath(orbit, 1).front();
    photos.push_back(view);
  }
  return photos;
}

double LeastDistance(const View& view, const std::vector<View>& photos) {
  double least = 1e9;
  for (const View& photo : photos) {
    least = std::min(
        least,
        (CameraCentre(view.cam_from_world) - CameraCentre(photo.cam_from_world))
            .norm());
  }
  return least;
}

TEST(FilmViewsTest, OrbitGoesAroundWhereThePhotosWere) {
  const auto photos = PhotosAround({0.3, 0.1, -0.2}, 2 * std::numbers::pi, 40);
  const auto views = OrbitOfScene(photos, 60);
  ASSERT_EQ(views.size(), 60u);
  EXPECT_EQ(views[0].name, "frame_0001.png");
  EXPECT_EQ(views[0].camera.width, 100);
  EXPECT_EQ(views[0].camera.height, 74);
  EXPECT_EQ(views[0].camera.cx, 50);
  for (const View& view : views) EXPECT_LT(LeastDistance(view, photos), 0.6);
}

TEST(FilmViewsTest, OrbitStaysOnTheSideThatWasSeen) {
  const auto photos = PhotosAround({0, 0, 0}, std::numbers::pi, 40);
  const auto views = OrbitOfScene(photos, 60);
  ASSERT_EQ(views.size(), 60u);
  for (const View& view : views) EXPECT_LT(LeastDistance(view, photos), 0.3);
}

TEST(FilmViewsTest, OneAndTwoPhotos) {
  for (const int count : {1, 2}) {
    const auto photos = PhotosAround({0, 0, 0}, 0.2, count);
    for (const auto& views : {OrbitOfScene(photos, 10),
                              PathThrough(photos, 10),
                              PathOfPhotos(photos, 10)}) {
      ASSERT_EQ(views.size(), 10u);
      for (const View& view : views) {
        EXPECT_TRUE(view.cam_from_world.Matrix3x4().allFinite());
        EXPECT_LT(LeastDistance(view, photos), 2);
      }
    }
  }
  EXPECT_TRUE(OrbitOfScene({}, 10).empty());
  EXPECT_TRUE(PathThrough({}, 10).empty());
}

// Three sweeps over half a circle: from the end of one the camera goes back the
// way it came, and neither through the middle nor behind it.
TEST(FilmViewsTest, GoesAroundWhatItLooksAt) {
  const auto sweep = PhotosAround({0, 0, 0}, std::numbers::pi, 40);
  std::vector<View> photos = sweep;
  photos.insert(photos.end(), sweep.begin(), sweep.end());
  const auto views = PathOfPhotos(photos, 200);
  ASSERT_EQ(views.size(), 200u);
  for (const View& view : views) {
    EXPECT_LT(LeastDistance(view, sweep), 0.5);
    const Eigen::Vector3d middle =
        view.cam_from_world * Eigen::Vector3d::Zero();
    EXPECT_LT(middle.head<2>().norm(), 0.2);
  }
  EXPECT_LT((CameraCentre(views.front().cam_from_world) -
             CameraCentre(photos.front().cam_from_world))
                .norm(),
            1e-6);
  EXPECT_LT((CameraCentre(views.back().cam_from_world) -
             CameraCentre(photos.back().cam_from_world))
                .norm(),
            1e-6);
}

// Also one that is far smaller than what the renderer draws nearby.
TEST(FilmViewsTest, ObjectFillsThePicture) {
  const auto photos = PhotosAround({0, 0, 0}, 2 * std::numbers::pi, 10);
  for (const double size : {0.01, 0.5, 20.0}) {
    splat::GaussianModel object;
    for (int k = 0; k < 8; ++k) {
      splat::GaussianModel corner;
      corner.Resize(1);
      corner.means = {static_cast<float>(7 + size * (k % 2)),
                      static_cast<float>(-3 + size * (k / 2 % 2)),
                      static_cast<float>(1 + size * (k / 4))};
      corner.log_scales.assign(3, static_cast<float>(std::log(size / 50)));
      corner.rotations = {1, 0, 0, 0};
      object.AppendFrom(corner, 0);
    }
    const auto views = OrbitOfObject(object, photos, 30);
    ASSERT_EQ(views.size(), 30u);
    double widest = 0;
    for (const View& view : views) {
      for (size_t i = 0; i < object.size(); ++i) {
        const Eigen::Vector3d point =
            view.cam_from_world * Eigen::Vector3d(object.means[3 * i],
                                                  object.means[3 * i + 1],
                                                  object.means[3 * i + 2]);
        EXPECT_GT(point.z(), 0.2);
        const double x = view.camera.fx * point.x() / point.z();
        const double y = view.camera.fy * point.y() / point.z();
        EXPECT_LT(std::abs(x), view.camera.width / 2);
        EXPECT_LT(std::abs(y), view.camera.height / 2);
        widest = std::max(widest, std::abs(y));
      }
    }
    EXPECT_GT(widest, 0.25 * views[0].camera.height) << size;
  }
}

}  // namespace
}  // namespace freegs::stages
