// SPDX-License-Identifier: BSD-3-Clause

#include "sfm/scene/scene_frame.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <Eigen/Geometry>
#include <nlohmann/json.hpp>

#include "core/decompositions.h"
#include "core/io/json_fields.h"
#include "core/random.h"
#include "sfm/scene/random_points.h"

namespace freegs::sfm {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kLevel = 5 * kDegree;     // Cameras held level are within.
constexpr double kFan = 3 * kDegree;       // Axes spread less are parallel.
constexpr double kWideFan = 15 * kDegree;  // Enough for full confidence.
constexpr double kNoAgreement = 0.1;       // Between the mean up axis and up.
constexpr double kFullAgreement = 0.5;
constexpr double kMaxParallelConfidence = 0.3;
constexpr double kOppositeConfidence = 0.1;  // When up may as well be down.
constexpr int kMaxPairs = 2000;
constexpr int kRefinements = 3;

constexpr int kPlaneDraws = 300;
constexpr size_t kPlanePoints = 4000;
constexpr double kPlaneThickness = 0.01;  // Share of the focus's distance.
constexpr double kMinPlaneShare = 0.1;
constexpr uint64_t kPairStream = 1;
constexpr uint64_t kPlaneStream = 2;

// Axes of the cameras, in the world.
struct CameraAxes {
  std::vector<Eigen::Vector3d> right;
  std::vector<Eigen::Vector3d> centres;
  Eigen::Vector3d mean_up = Eigen::Vector3d::Zero();
  Eigen::Vector3d mean_forward = Eigen::Vector3d::Zero();
  Eigen::Vector3d first_right = Eigen::Vector3d::UnitX();
};

CameraAxes ReadAxes(const Reconstruction& model) {
  CameraAxes axes;
  const PosedImage* first = nullptr;
  for (const PosedImage& image : model.images) {
    const Eigen::Matrix3d rotation =
        image.cam_from_world.rotation.toRotationMatrix();
    axes.right.emplace_back(rotation.row(0));
    axes.centres.push_back(CameraCentre(image.cam_from_world));
    axes.mean_up -= rotation.row(1).transpose();
    axes.mean_forward += rotation.row(2).transpose();
    if (first == nullptr || image.name < first->name) {
      first = &image;
      axes.first_right = rotation.row(0);
    }
  }
  const auto count = static_cast<double>(model.images.size());
  axes.mean_up /= count;
  axes.mean_forward /= count;
  return axes;
}

// Angle between an axis and the plane with this normal, 0..pi/2.
double AngleToPlane(const Eigen::Vector3d& axis,
                    const Eigen::Vector3d& normal) {
  return std::asin(std::min(1.0, std::abs(axis.dot(normal))));
}

// The normal that most axes are perpendicular to: of normals to pairs of axes
// the one with the least sum of squared angles, each at most kLevel.
Eigen::Vector3d ConsensusNormal(const std::vector<Eigen::Vector3d>& axes) {
  Eigen::Vector3d best = Eigen::Vector3d::Zero();
  double best_cost = std::numeric_limits<double>::infinity();
  const auto try_pair = [&](size_t i, size_t j) {
    const Eigen::Vector3d cross = axes[i].cross(axes[j]);
    if (cross.norm() < std::sin(kFan)) return;
    const Eigen::Vector3d normal = cross.normalized();
    double cost = 0;
    for (const Eigen::Vector3d& axis : axes) {
      const double angle = std::min(AngleToPlane(axis, normal), kLevel);
      cost += angle * angle;
    }
    if (cost < best_cost) {
      best_cost = cost;
      best = normal;
    }
  };
  const size_t count = axes.size();
  if (count * (count - 1) / 2 <= kMaxPairs) {
    for (size_t i = 0; i < count; ++i) {
      for (size_t j = i + 1; j < count; ++j) try_pair(i, j);
    }
  } else {
    RandomStream random(0, kPairStream);
    for (int k = 0; k < kMaxPairs; ++k) {
      const size_t i = random.Index(count);
      try_pair(i, random.Index(count));
    }
  }
  return best;
}

// Level cameras for a normal, and the fit to them.
struct LevelFit {
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  double share = 0;  // Share of all cameras.
  double rms = 0;    // Radians.
  double fan = 0;    // Spread of the axes within the plane, radians.
};

LevelFit FitLevel(const std::vector<Eigen::Vector3d>& axes,
                  const Eigen::Vector3d& start) {
  LevelFit fit;
  fit.normal = start;
  for (int round = 0; round < kRefinements; ++round) {
    Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
    size_t level = 0;
    for (const Eigen::Vector3d& axis : axes) {
      if (AngleToPlane(axis, fit.normal) > kLevel) continue;
      scatter += axis * axis.transpose();
      ++level;
    }
    if (level < 2) break;
    scatter /= static_cast<double>(level);
    const SymmetricEigen3 eigen = DecomposeSymmetric(scatter);
    fit.normal = eigen.vectors.col(0);
    fit.rms = std::asin(std::sqrt(std::clamp(eigen.values[0], 0., 1.)));
    fit.fan = std::asin(std::sqrt(std::clamp(eigen.values[1], 0., 1.)));
    fit.share = static_cast<double>(level) / static_cast<double>(axes.size());
  }
  return fit;
}

// The mean of the cameras' up axes, perpendicular to their parallel horizontal
// axes.
void UseCameraUp(const CameraAxes& axes, SceneFrame* frame) {
  frame->source = UpSource::kCameraUp;
  Eigen::Vector3d up = axes.mean_up;
  if (up.norm() < kNoAgreement) up = -axes.mean_forward;
  if (up.norm() < 1e-9) up = Eigen::Vector3d::UnitZ();
  frame->confidence =
      kMaxParallelConfidence * std::min(1.0, axes.mean_up.norm());
  frame->up = up.normalized();
}

void FindUp(const CameraAxes& axes, SceneFrame* frame) {
  const Eigen::Vector3d start = ConsensusNormal(axes.right);
  LevelFit fit;
  if (start.norm() > 0) fit = FitLevel(axes.right, start);
  if (fit.fan < kFan) {
    UseCameraUp(axes, frame);
    return;
  }
  frame->source = UpSource::kHorizon;
  frame->up = fit.normal;
  frame->tilt_rms_deg = fit.rms / kDegree;
  const double agreement = axes.mean_up.dot(fit.normal);
  frame->confidence = fit.share * std::min(1.0, fit.fan / kWideFan) *
                      std::min(1.0, std::abs(agreement) / kFullAgreement);
  double side = agreement;
  if (std::abs(agreement) < kNoAgreement) {
    // Straight down, or straight ahead with a rolling camera. People look down
    // at things more often than up.
    side = -axes.mean_forward.dot(fit.normal);
    frame->confidence = std::min(frame->confidence, kOppositeConfidence);
  }
  if (side < 0) frame->up = -frame->up;
}

// Returns at most kPlanePoints points, evenly chosen from the list.
std::vector<Eigen::Vector3d> SomePoints(const Reconstruction& model) {
  std::vector<Eigen::Vector3d> points;
  const size_t step = std::max<size_t>(
      1, (model.points3d.size() + kPlanePoints - 1) / kPlanePoints);
  for (size_t i = 0; i < model.points3d.size(); i += step) {
    points.push_back(model.points3d[i].xyz);
  }
  return points;
}

std::optional<GroundPlane> FindGround(const Reconstruction& model,
                                      const CameraAxes& axes,
                                      const SceneFrame& frame) {
  const std::vector<Eigen::Vector3d> points = SomePoints(model);
  if (points.size() < 20) return std::nullopt;
  RandomStream random(0, kPlaneStream);
  const double thickness = kPlaneThickness * frame.distance;
  size_t most = 0;
  GroundPlane ground;
  for (int draw = 0; draw < kPlaneDraws; ++draw) {
    const Eigen::Vector3d& a = points[random.Index(points.size())];
    const Eigen::Vector3d& b = points[random.Index(points.size())];
    const Eigen::Vector3d& c = points[random.Index(points.size())];
    const Eigen::Vector3d cross = (b - a).cross(c - a);
    if (cross.norm() < thickness * thickness) continue;
    Eigen::Vector3d normal = cross.normalized();
    if (normal.dot(axes.centres[0] - a) < 0) normal = -normal;
    const bool one_side = std::all_of(
        axes.centres.begin(), axes.centres.end(), [&](const auto& centre) {
          return normal.dot(centre - a) > 0;
        });
    if (!one_side) continue;
    const auto on_it = static_cast<size_t>(std::count_if(
        points.begin(), points.end(), [&](const Eigen::Vector3d& point) {
          return std::abs(normal.dot(point - a)) < thickness;
        }));
    if (on_it <= most) continue;
    most = on_it;
    ground.normal = normal;
  }
  ground.point_share =
      static_cast<double>(most) / static_cast<double>(points.size());
  if (ground.point_share < kMinPlaneShare) return std::nullopt;
  ground.angle_to_up_deg =
      std::acos(std::clamp(ground.normal.dot(frame.up), -1.0, 1.0)) / kDegree;
  return ground;
}

Eigen::Matrix4d FrameFromWorld(const SceneFrame& frame,
                               const Eigen::Vector3d& right) {
  const Eigen::Vector3d& z = frame.up;
  Eigen::Vector3d x = right - right.dot(z) * z;
  if (x.norm() < 1e-6) x = z.unitOrthogonal();
  x.normalize();
  Eigen::Matrix3d rotation;
  rotation.row(0) = x;
  rotation.row(1) = z.cross(x);
  rotation.row(2) = z;
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.topLeftCorner<3, 3>() = rotation / frame.distance;
  matrix.topRightCorner<3, 1>() = -(rotation * frame.centre) / frame.distance;
  return matrix;
}

}  // namespace

std::string_view UpSourceName(UpSource source) {
  return source == UpSource::kHorizon ? "horizon" : "camera_up";
}

StatusOr<SceneFrame> EstimateSceneFrame(const Reconstruction& model) {
  if (model.images.empty()) {
    return BadInputError("a model without images has no frame");
  }
  const CameraAxes axes = ReadAxes(model);
  SceneFrame frame;
  FindUp(axes, &frame);
  const SceneFocus focus = EstimateFocus(model);
  frame.centre = focus.centre;
  if (std::isfinite(focus.distance) && focus.distance > 0) {
    frame.distance = focus.distance;
  }
  frame.ground = FindGround(model, axes, frame);
  frame.frame_from_world = FrameFromWorld(frame, axes.first_right);
  return frame;
}

nlohmann::ordered_json SceneFrameToJson(const SceneFrame& frame) {
  nlohmann::ordered_json json;
  json["version"] = 1;
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) rows.push_back(frame.frame_from_world(i, j));
  }
  json["frame_from_world"] = std::move(rows);
  json["up"] = VectorJson(frame.up);
  json["up_source"] = UpSourceName(frame.source);
  json["up_confidence"] = frame.confidence;
  json["tilt_rms_deg"] = frame.tilt_rms_deg;
  json["centre"] = VectorJson(frame.centre);
  json["distance"] = frame.distance;
  json["scale_source"] = "median distance of the cameras from what they see";
  json["metric"] = false;
  json["ground"] = nullptr;
  if (frame.ground) {
    json["ground"] = {{"normal", VectorJson(frame.ground->normal)},
                      {"point_share", frame.ground->point_share},
                      {"angle_to_up_deg", frame.ground->angle_to_up_deg}};
  }
  return json;
}

}  // namespace freegs::sfm
