// SPDX-License-Identifier: BSD-3-Clause

#include "stages/scene/working_frame.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "core/number_text.h"
#include "core/quantile.h"
#include "sfm/scene/random_points.h"

namespace freegs::stages {
namespace {

// So many views and points, evenly spread, are enough for medians.
constexpr size_t kMaxViews = 64;
constexpr size_t kMaxPoints = 4000;

constexpr int kThumbnailSide = 96;  // Pixels.

bool IsInside(const Pinhole& camera, const Eigen::Vector3d& point) {
  if (!(point.z() > 0)) return false;
  const double x = camera.fx * point.x() / point.z() + camera.cx;
  const double y = camera.fy * point.y() / point.z() + camera.cy;
  return x >= 0 && y >= 0 && x < camera.width && y < camera.height;
}

}  // namespace

splat::ModelFrame ChooseFrame(const sfm::Reconstruction& sparse,
                              std::span<const View> views) {
  std::array<std::vector<double>, 3> coordinates;
  std::vector<double> depths;
  const size_t view_step = views.size() / kMaxViews + 1;
  const size_t point_step = sparse.points3d.size() / kMaxPoints + 1;
  for (size_t v = 0; v < views.size(); v += view_step) {
    for (size_t p = 0; p < sparse.points3d.size(); p += point_step) {
      const Eigen::Vector3d& world = sparse.points3d[p].xyz;
      const Eigen::Vector3d seen = views[v].cam_from_world * world;
      if (!IsInside(views[v].camera, seen)) continue;
      depths.push_back(seen.z());
      for (int k = 0; k < 3; ++k) coordinates[k].push_back(world[k]);
    }
  }
  splat::ModelFrame frame;
  double depth = 0;
  if (depths.empty()) {
    const sfm::SceneFocus focus = sfm::EstimateFocus(sparse);
    frame.origin = focus.centre;
    depth = focus.distance;
  } else {
    for (int k = 0; k < 3; ++k) {
      frame.origin[k] = UpperMedian(std::move(coordinates[k]));
    }
    depth = UpperMedian(std::move(depths));
  }
  frame.unit = depth / splat::kTypicalDepth;
  return frame;
}

void MoveToFrame(const splat::ModelFrame& frame, sfm::Reconstruction* sparse) {
  // What double precision loses far from the origin is taken out again, so that
  // the same scene trains the same way wherever it lies. The step is less than
  // a thousandth of a pixel.
  const auto rounded = [](const Eigen::Vector3d& x) -> Eigen::Vector3d {
    constexpr double kStep = 1.0 / (1 << 18);
    return (x / kStep).array().round() * kStep;
  };
  const Sim3d frame_from_world = frame.FrameFromWorld();
  for (sfm::PosedImage& image : sparse->images) {
    image.cam_from_world =
        TransformCamera(frame_from_world, image.cam_from_world);
    image.cam_from_world.translation =
        rounded(image.cam_from_world.translation);
  }
  for (sfm::Point3D& point : sparse->points3d) {
    point.xyz = rounded((point.xyz - frame.origin) / frame.unit);
  }
}

semantics::Instance InWorld(const splat::ModelFrame& frame,
                            semantics::Instance instance) {
  const Sim3d world_from_frame = frame.WorldFromFrame();
  instance.centre = world_from_frame * instance.centre;
  instance.aabb.min = world_from_frame * instance.aabb.min;
  instance.aabb.max = world_from_frame * instance.aabb.max;
  instance.obb.centre = world_from_frame * instance.obb.centre;
  instance.obb.size *= frame.unit;
  return instance;
}

std::string FarAwayNote(const splat::ModelFrame& frame) {
  if (!frame.IsFarAway()) return "";
  const double size = splat::kTypicalDepth * frame.unit;
  const double distance = frame.origin.norm();
  // Half the distance between neighbouring float32 numbers of this size.
  const double loss = std::ldexp(distance, -24);
  return "the scene lies " + FormatSignificant(distance / size, 2) +
         " times its size from the origin of its world, where float32 "
         "positions would be off by up to " +
         FormatSignificant(loss, 2) +
         " units; positions in PLY, .splat and .spz files count from " +
         FormatSignificant(frame.origin.x(), 17) + " " +
         FormatSignificant(frame.origin.y(), 17) + " " +
         FormatSignificant(frame.origin.z(), 17) +
         " instead, which the line \"comment offset\" of a PLY file says";
}

Status CheckVisible(const splat::GaussianModel& model,
                    std::span<const View> views,
                    const splat::RenderOptions& render,
                    ThreadPool& pool) {
  for (const View& view : views) {
    const splat::RenderedView rendered =
        splat::RenderView(model,
                          view.camera.LimitedTo(kThumbnailSide),
                          view.cam_from_world,
                          render,
                          pool);
    const float* const transmittance = rendered.transmittance.data();
    const size_t pixels = rendered.transmittance.size();
    if (std::any_of(transmittance, transmittance + pixels, [](float t) {
          return t < 1;
        })) {
      return Status();
    }
  }
  return UnusableResultError(
      "none of the " + std::to_string(model.size()) +
      " Gaussians is visible in any of the " + std::to_string(views.size()) +
      " views; check that the Gaussians and the camera poses are in the same "
      "world frame");
}

}  // namespace freegs::stages
