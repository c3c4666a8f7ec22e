// SPDX-License-Identifier: BSD-3-Clause

#include "stages/film/film_views.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include <Eigen/Dense>

#include "core/quantile.h"
#include "semantics/instances/instances.h"
#include "splat/scene/model_frame.h"
#include "stages/film/camera_path.h"

namespace freegs::stages {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

Pinhole EvenSize(Pinhole camera) {
  camera.width = std::max(2, camera.width - camera.width % 2);
  camera.height = std::max(2, camera.height - camera.height % 2);
  return camera;
}

std::vector<View> MakeViews(const std::vector<Rigid3d>& poses,
                            const Pinhole& camera) {
  std::vector<View> views;
  for (const Rigid3d& pose : poses) {
    views.push_back({FrameName(views.size()), EvenSize(camera), pose});
  }
  return views;
}

Eigen::Vector3d Forward(const View& view) {
  return view.cam_from_world.rotation.conjugate() * Eigen::Vector3d::UnitZ();
}

Eigen::Vector3d UpOfViews(const std::vector<View>& views) {
  const auto up = semantics::EstimateVertical(views, {});
  return up ? *up
            : semantics::BentToLevelCameras(views, -Eigen::Vector3d::UnitY());
}

// The point nearest to all optical axes. The origin, which is the middle of the
// scene's points, counts a little, so that parallel axes have such a point,
// too; it is taken alone when the cameras look away from each other.
Eigen::Vector3d LookedAt(const std::vector<View>& views) {
  constexpr double kWeightOfOrigin = 0.02;
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Zero();
  Eigen::Vector3d vector = Eigen::Vector3d::Zero();
  for (const View& view : views) {
    const Eigen::Vector3d axis = Forward(view);
    const Eigen::Matrix3d across =
        Eigen::Matrix3d::Identity() - axis * axis.transpose();
    matrix += across + kWeightOfOrigin * Eigen::Matrix3d::Identity();
    vector += across * CameraCentre(view.cam_from_world);
  }
  const Eigen::Vector3d point = matrix.ldlt().solve(vector);
  const auto in_front =
      std::count_if(views.begin(), views.end(), [&](const View& view) {
        return (view.cam_from_world * point).z() > 0;
      });
  const bool most = 4 * in_front >= 3 * std::ssize(views);
  return most ? point : Eigen::Vector3d::Zero();
}

// Leaves out the widest gap between neighbouring azimuths, if it is wide.
void SetArc(std::vector<double> azimuths, Orbit* orbit) {
  constexpr double kWideGap = std::numbers::pi / 2;
  constexpr double kLeastArc = 20 * kDegree;
  std::sort(azimuths.begin(), azimuths.end());
  const double full = 2 * std::numbers::pi;
  double gap = 0;
  for (size_t i = 0; i < azimuths.size(); ++i) {
    const bool last = i + 1 == azimuths.size();
    const double next = last ? azimuths.front() + full : azimuths[i + 1];
    if (next - azimuths[i] <= gap) continue;
    gap = next - azimuths[i];
    orbit->first_azimuth = next;
  }
  if (gap <= kWideGap) return;
  orbit->arc = full - gap;
  if (orbit->arc >= kLeastArc) return;
  orbit->first_azimuth -= (kLeastArc - orbit->arc) / 2;
  orbit->arc = kLeastArc;
}

// Where a camera is as seen from an orbit.
struct OrbitPlace {
  double azimuth = 0;  // first_azimuth and up to a full turn more.
  double radius = 0;
  double height = 0;
};

struct PhotoOrbit {
  Orbit orbit;
  std::vector<OrbitPlace> places;  // One per photo.
};

PhotoOrbit OrbitOfPhotos(const std::vector<View>& photos) {
  constexpr double kRounding = 1e-9;  // The first azimuth itself is not behind.
  PhotoOrbit result;
  Orbit& orbit = result.orbit;
  orbit.centre = LookedAt(photos);
  orbit.up = UpOfViews(photos);
  const Eigen::Matrix3d axes = OrbitAxes(orbit.up);
  std::vector<double> radii;
  std::vector<double> heights;
  std::vector<double> azimuths;
  for (const View& view : photos) {
    const Eigen::Vector3d away =
        axes.transpose() * (CameraCentre(view.cam_from_world) - orbit.centre);
    radii.push_back(away.head<2>().norm());
    heights.push_back(away.z());
    azimuths.push_back(std::atan2(away.y(), away.x()));
  }
  // Rather far than near: photos of details should not decide.
  orbit.radius = std::max(NearestQuantile(radii, 0.75), 1e-3);
  orbit.height = Median(heights);
  SetArc(azimuths, &orbit);
  for (size_t i = 0; i < photos.size(); ++i) {
    const double turns =
        (azimuths[i] - orbit.first_azimuth) / (2 * std::numbers::pi);
    result.places.push_back(
        {orbit.first_azimuth +
             2 * std::numbers::pi * (turns - std::floor(turns + kRounding)),
         radii[i],
         heights[i]});
  }
  return result;
}

std::vector<Rigid3d> PosesOf(const std::vector<View>& views) {
  std::vector<Rigid3d> poses;
  for (const View& view : views) poses.push_back(view.cam_from_world);
  return poses;
}

// The step from one azimuth to another: not across the gap that the photos
// leave, and the shorter way where they leave none.
double AzimuthStep(const Orbit& orbit, double from, double to) {
  const double full = 2 * std::numbers::pi;
  const double step = to - from;
  if (orbit.arc < full || std::abs(step) <= full / 2) return step;
  return step > 0 ? step - full : step + full;
}

// Appends poses between photo i and the next, about 15 degrees apart. In each
// the camera is turned against the look to the centre as it is in the photos.
void AddDetour(const PhotoOrbit& around,
               const std::vector<Rigid3d>& photos,
               size_t i,
               double step,
               std::vector<Rigid3d>* poses) {
  const OrbitPlace& from = around.places[i];
  const OrbitPlace& to = around.places[i + 1];
  const auto look = [&](double t) {
    Orbit orbit = around.orbit;
    orbit.radius = from.radius + t * (to.radius - from.radius);
    orbit.height = from.height + t * (to.height - from.height);
    return OrbitPose(orbit, from.azimuth + t * step);
  };
  const Eigen::Quaterniond turn_from =
      photos[i].rotation * look(0).rotation.conjugate();
  const Eigen::Quaterniond turn_to =
      photos[i + 1].rotation * look(1).rotation.conjugate();
  const int count = static_cast<int>(std::abs(step) / (15 * kDegree));
  for (int k = 1; k <= count; ++k) {
    const double t = static_cast<double>(k) / (count + 1);
    const Rigid3d turn = {turn_from.slerp(t, turn_to), Eigen::Vector3d::Zero()};
    poses->push_back(turn * look(t));
  }
}

std::vector<Rigid3d> PosesWithDetours(const std::vector<View>& photos) {
  constexpr double kLeastStep = 40 * kDegree;
  constexpr double kTimesMedian = 4;
  const PhotoOrbit around = OrbitOfPhotos(photos);
  std::vector<double> steps;
  std::vector<double> sizes;
  for (size_t i = 0; i + 1 < photos.size(); ++i) {
    steps.push_back(AzimuthStep(
        around.orbit, around.places[i].azimuth, around.places[i + 1].azimuth));
    sizes.push_back(std::abs(steps.back()));
  }
  const double far = std::max(kLeastStep, kTimesMedian * Median(sizes));
  const std::vector<Rigid3d> given = PosesOf(photos);
  std::vector<Rigid3d> poses;
  for (size_t i = 0; i < given.size(); ++i) {
    poses.push_back(given[i]);
    if (i < steps.size() && sizes[i] > far) {
      AddDetour(around, given, i, steps[i], &poses);
    }
  }
  return poses;
}

// The middle of what can be seen of the model, and the radius of a sphere
// around it that holds nearly all of it.
struct Ball {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double radius = 0;
};

Ball BallOf(const splat::GaussianModel& model) {
  constexpr double kShare = 0.98;
  constexpr float kVisibleLogit = -2.2f;  // An opacity of 0.1.
  std::vector<size_t> visible;
  for (size_t i = 0; i < model.size(); ++i) {
    if (model.opacity_logits[i] > kVisibleLogit) visible.push_back(i);
  }
  if (visible.empty()) {
    for (size_t i = 0; i < model.size(); ++i) visible.push_back(i);
  }
  Ball ball;
  if (visible.empty()) return ball;
  for (int k = 0; k < 3; ++k) {
    std::vector<double> values;
    for (const size_t i : visible) values.push_back(model.means[3 * i + k]);
    // Between the ends without strays, as the sides of an object may have
    // different numbers of Gaussians.
    std::sort(values.begin(), values.end());
    const auto stray = static_cast<size_t>((1 - kShare) / 2 *
                                           static_cast<double>(values.size()));
    ball.centre[k] = (values[stray] + values[values.size() - 1 - stray]) / 2;
  }
  std::vector<double> distances;
  for (const size_t i : visible) {
    const Eigen::Vector3d mean(
        model.means[3 * i], model.means[3 * i + 1], model.means[3 * i + 2]);
    const float* const scales = &model.log_scales[3 * i];
    distances.push_back((mean - ball.centre).norm() +
                        std::exp(*std::max_element(scales, scales + 3)));
  }
  std::sort(distances.begin(), distances.end());
  ball.radius = distances[static_cast<size_t>(
      kShare * static_cast<double>(distances.size() - 1))];
  return ball;
}

double ElevationOf(const View& view,
                   const Eigen::Vector3d& centre,
                   const Eigen::Vector3d& up) {
  const Eigen::Vector3d away = CameraCentre(view.cam_from_world) - centre;
  return std::asin(std::clamp(away.normalized().dot(up), -1.0, 1.0));
}

}  // namespace

std::string FrameName(size_t frame) {
  char name[32];
  std::snprintf(name, sizeof(name), "frame_%04zu.png", frame + 1);
  return name;
}

std::vector<View> PathThrough(const std::vector<View>& views, int num_frames) {
  if (views.empty()) return {};
  return MakeViews(
      SmoothPath(PosesOf(views),
                 {.num_frames = num_frames, .depth = splat::kTypicalDepth}),
      views.front().camera);
}

std::vector<View> PathOfPhotos(const std::vector<View>& photos,
                               int num_frames) {
  if (photos.empty()) return {};
  return MakeViews(SmoothPath(PosesWithDetours(photos),
                              {.num_frames = num_frames,
                               .smoothing = 2,
                               .depth = splat::kTypicalDepth}),
                   photos.front().camera);
}

std::vector<View> OrbitOfScene(const std::vector<View>& photos,
                               int num_frames) {
  if (photos.empty()) return {};
  return MakeViews(OrbitPath(OrbitOfPhotos(photos).orbit, num_frames),
                   photos.front().camera);
}

std::vector<View> OrbitOfObject(const splat::GaussianModel& model,
                                const std::vector<View>& photos,
                                int num_frames) {
  if (photos.empty()) return {};
  const Ball ball = BallOf(model);
  const Eigen::Vector3d up = UpOfViews(photos);
  std::vector<double> elevations;
  for (const View& view : photos) {
    elevations.push_back(ElevationOf(view, ball.centre, up));
  }
  const double elevation =
      std::clamp(Median(elevations), 10 * kDegree, 45 * kDegree);
  Pinhole camera = photos.front().camera;
  camera.cx = camera.width / 2.0;
  camera.cy = camera.height / 2.0;
  const double half_angle = std::atan(
      std::min(camera.width / camera.fx, camera.height / camera.fy) / 2);
  const double radius = std::max(ball.radius, 1e-4);
  const double fitting = 1.05 * radius / std::sin(half_angle);
  // A small object is looked at from farther away through a longer lens: the
  // renderer leaves out what is nearer than its near plane.
  const double distance = std::max(fitting, 1 + 2 * radius);
  camera.fx *= distance / fitting;
  camera.fy *= distance / fitting;
  Orbit orbit;
  orbit.centre = ball.centre;
  orbit.up = up;
  orbit.radius = distance * std::cos(elevation);
  orbit.height = distance * std::sin(elevation);
  return MakeViews(OrbitPath(orbit, num_frames), camera);
}

}  // namespace freegs::stages
