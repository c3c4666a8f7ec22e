// SPDX-License-Identifier: BSD-3-Clause

#include "sfm/import/quarter_turn.h"

#include <utility>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace freegs::sfm {
namespace {

// A right angle clockwise takes (x, y), with y down, to (-y, x).
void TurnVector(double* x, double* y) {
  std::swap(*x, *y);
  *x = -*x;
}

// Once. A lens is the same in all directions but for decentring and prisms,
// whose parameters form vectors: (p2, p1) and (sx1, sy1).
void TurnCamera(Camera* camera) {
  const int num_focal = GetCameraModel(camera->model).num_focal;
  std::vector<double>& params = camera->params;
  if (num_focal == 2) std::swap(params[0], params[1]);
  double& cx = params[num_focal];
  double& cy = params[num_focal + 1];
  TurnVector(&cx, &cy);
  cx += static_cast<double>(camera->height);
  switch (camera->model) {
    case CameraModel::kOpenCv:
    case CameraModel::kFullOpenCv:
      TurnVector(&params[7], &params[6]);
      break;
    case CameraModel::kThinPrismFisheye:
      TurnVector(&params[7], &params[6]);
      TurnVector(&params[10], &params[11]);
      break;
    default:
      break;
  }
  std::swap(camera->width, camera->height);
}

}  // namespace

int QuarterTurns(int orientation) {
  if (orientation == 6) return 1;
  if (orientation == 8) return 3;
  return 0;
}

void TurnClockwise(int quarter_turns, Camera* camera, PosedImage* image) {
  const Eigen::Quaterniond turn(
      Eigen::AngleAxisd(EIGEN_PI / 2, Eigen::Vector3d::UnitZ()));
  for (int k = 0; k < quarter_turns; ++k) {
    const auto height = static_cast<double>(camera->height);
    TurnCamera(camera);
    for (Point2D& point : image->points2d) {
      TurnVector(&point.xy.x(), &point.xy.y());
      point.xy.x() += height;
    }
    image->cam_from_world = Rigid3d{.rotation = turn} * image->cam_from_world;
  }
}

}  // namespace freegs::sfm
