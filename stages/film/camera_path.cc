// SPDX-License-Identifier: BSD-3-Clause

#include "stages/film/camera_path.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include <Eigen/Geometry>

namespace freegs::stages {
namespace {

// Between two poses the length of the path is measured in so many pieces.
constexpr int kPieces = 64;

// A camera's centre and world_from_cam, as one vector to interpolate.
struct PathPose {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  Eigen::Vector4d turn = Eigen::Vector4d::UnitW();  // x y z w.
};

PathPose operator+(const PathPose& a, const PathPose& b) {
  return {a.centre + b.centre, a.turn + b.turn};
}
PathPose operator*(double s, const PathPose& a) {
  return {s * a.centre, s * a.turn};
}

PathPose Normalized(PathPose pose) {
  pose.turn.normalize();
  return pose;
}

Rigid3d ToRigid(const PathPose& pose) {
  const Rigid3d world_from_cam = {Eigen::Quaterniond(pose.turn).normalized(),
                                  pose.centre};
  return Inverse(world_from_cam);
}

double PathLength(const PathPose& a, const PathPose& b, double depth) {
  const double chord =
      std::min((a.turn - b.turn).norm(), (a.turn + b.turn).norm());
  return (a.centre - b.centre).norm() / depth +
         4 * std::asin(std::min(1.0, chord / 2));
}

// q and -q are the same rotation; each has the sign that is nearer to the one
// before, so that sums of them make sense.
std::vector<PathPose> PathPoses(std::span<const Rigid3d> poses) {
  std::vector<PathPose> result;
  for (const Rigid3d& cam_from_world : poses) {
    const Rigid3d world_from_cam = Inverse(cam_from_world);
    PathPose pose = {world_from_cam.translation,
                     world_from_cam.rotation.coeffs().normalized()};
    if (!result.empty() && result.back().turn.dot(pose.turn) < 0) {
      pose.turn = -pose.turn;
    }
    result.push_back(pose);
  }
  return result;
}

void Smooth(std::vector<PathPose>* poses) {
  const std::vector<PathPose> before = *poses;
  for (size_t i = 1; i + 1 < before.size(); ++i) {
    (*poses)[i] =
        Normalized(0.5 * before[i] + 0.25 * (before[i - 1] + before[i + 1]));
  }
}

// A cubic between each two poses. Its slope at a pose is the mean of those to
// both neighbours, weighted so that the nearer one counts more (Catmull-Rom for
// uneven distances).
class PathCurve {
 public:
  // Two poses or more, of which no two in a row are equal.
  PathCurve(std::vector<PathPose> poses, double depth)
      : poses_(std::move(poses)) {
    const size_t num_steps = poses_.size() - 1;
    std::vector<PathPose> slopes(num_steps);
    for (size_t i = 0; i < num_steps; ++i) {
      // The square root keeps the curve from swinging out beside a long step.
      steps_.push_back(std::sqrt(PathLength(poses_[i], poses_[i + 1], depth)));
      slopes[i] = (1 / steps_[i]) * (poses_[i + 1] + -1 * poses_[i]);
    }
    slopes_.push_back(slopes.front());
    for (size_t i = 1; i < num_steps; ++i) {
      const double sum = steps_[i - 1] + steps_[i];
      slopes_.push_back((steps_[i] / sum) * slopes[i - 1] +
                        (steps_[i - 1] / sum) * slopes[i]);
    }
    slopes_.push_back(slopes.back());
  }

  size_t num_steps() const { return steps_.size(); }

  // `at` runs from 0 to num_steps().
  PathPose At(double at) const {
    const size_t i = std::min(static_cast<size_t>(at), num_steps() - 1);
    const double t = at - static_cast<double>(i);
    const double rest = 1 - t;
    return Normalized(((1 + 2 * t) * rest * rest) * poses_[i] +
                      ((3 - 2 * t) * t * t) * poses_[i + 1] +
                      steps_[i] * ((t * rest * rest) * slopes_[i] +
                                   (-t * t * rest) * slopes_[i + 1]));
  }

 private:
  std::vector<PathPose> poses_;
  std::vector<double> steps_;     // From each pose to the next.
  std::vector<PathPose> slopes_;  // At each pose.
};

}  // namespace

std::vector<Rigid3d> SmoothPath(std::span<const Rigid3d> poses,
                                const SmoothPathOptions& options) {
  if (poses.empty() || options.num_frames < 1) return {};
  std::vector<PathPose> keys = PathPoses(poses);
  for (int k = 0; k < options.smoothing; ++k) Smooth(&keys);
  constexpr double kSame = 1e-9;
  const auto same = [&](const PathPose& a, const PathPose& b) {
    return PathLength(a, b, options.depth) < kSame;
  };
  keys.erase(std::unique(keys.begin(), keys.end(), same), keys.end());
  const auto num_frames = static_cast<size_t>(options.num_frames);
  if (keys.size() == 1 || num_frames == 1) {
    return std::vector<Rigid3d>(num_frames, ToRigid(keys.front()));
  }

  const PathCurve curve(std::move(keys), options.depth);
  // How far along the path the ends of the pieces are.
  std::vector<double> lengths = {0};
  PathPose before = curve.At(0);
  for (size_t piece = 1; piece <= curve.num_steps() * kPieces; ++piece) {
    const PathPose pose = curve.At(static_cast<double>(piece) / kPieces);
    lengths.push_back(lengths.back() + PathLength(before, pose, options.depth));
    before = pose;
  }
  std::vector<Rigid3d> frames;
  size_t piece = 0;
  for (size_t k = 0; k < num_frames; ++k) {
    const double wanted = lengths.back() * static_cast<double>(k) /
                          static_cast<double>(num_frames - 1);
    while (piece + 2 < lengths.size() && lengths[piece + 1] < wanted) ++piece;
    const double length = lengths[piece + 1] - lengths[piece];
    const double part =
        length > 0 ? std::min(1.0, (wanted - lengths[piece]) / length) : 0;
    frames.push_back(
        ToRigid(curve.At((static_cast<double>(piece) + part) / kPieces)));
  }
  return frames;
}

Eigen::Matrix3d OrbitAxes(const Eigen::Vector3d& up) {
  Eigen::Matrix3d axes;
  axes.col(2) = up;
  axes.col(0) = up.unitOrthogonal();
  axes.col(1) = up.cross(axes.col(0));
  return axes;
}

Rigid3d OrbitPose(const Orbit& orbit, double azimuth) {
  const Eigen::Matrix3d axes = OrbitAxes(orbit.up);
  const Eigen::Vector3d offset =
      axes * Eigen::Vector3d(orbit.radius * std::cos(azimuth),
                             orbit.radius * std::sin(azimuth),
                             orbit.height);
  // The camera's x, y and z axes: right, down, and towards the centre.
  Eigen::Matrix3d world_from_cam;
  world_from_cam.col(2) = -offset.normalized();
  // Level also where the camera looks straight down.
  world_from_cam.col(0) =
      -std::sin(azimuth) * axes.col(0) + std::cos(azimuth) * axes.col(1);
  world_from_cam.col(1) = world_from_cam.col(2).cross(world_from_cam.col(0));
  return Inverse({Eigen::Quaterniond(world_from_cam), orbit.centre + offset});
}

std::vector<Rigid3d> OrbitPath(const Orbit& orbit, int num_frames) {
  const double full = 2 * std::numbers::pi;
  std::vector<Rigid3d> frames;
  for (int k = 0; k < num_frames; ++k) {
    const double turn = full * k / num_frames;
    const double part =
        orbit.arc >= full ? turn / full : (1 - std::cos(turn)) / 2;
    frames.push_back(OrbitPose(orbit, orbit.first_azimuth + orbit.arc * part));
  }
  return frames;
}

}  // namespace freegs::stages
