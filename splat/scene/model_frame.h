// SPDX-License-Identifier: BSD-3-Clause
// The frame of a model's float32 numbers, and its way to the world frame and
// back. A world may count in millimetres, or from a place far away; the numbers
// of a model should be near 1, so that float32 holds them and constants such as
// RenderOptions::near_plane mean the same in every scene.
//
//   FREEGS_ASSIGN_OR_RETURN(const PlacedModel file, ReadPly("scene.ply"));
//   const GaussianModel model = ToFrame(file, frame);
//   ...
//   const PlacedModel moved = ToWorld(model, frame);
//   FREEGS_RETURN_IF_ERROR(WritePly("moved.ply", moved.model, moved.offset));

#ifndef FREEGS_SPLAT_SCENE_MODEL_FRAME_H_
#define FREEGS_SPLAT_SCENE_MODEL_FRAME_H_

#include <Eigen/Core>

#include "core/rigid3d.h"
#include "splat/scene/gaussian_model.h"

namespace freegs::splat {

// What cameras see is typically so far from them, in units of a ModelFrame that
// was chosen for its scene. Models of COLMAP have about the same size.
inline constexpr double kTypicalDepth = 5;

// A frame whose axes are parallel to those of the world.
struct ModelFrame {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  // In the world.
  double unit = 1;                                   // In world units; > 0.

  Sim3d FrameFromWorld() const {
    return {1 / unit, Eigen::Quaterniond::Identity(), -origin / unit};
  }
  Sim3d WorldFromFrame() const {
    return {unit, Eigen::Quaterniond::Identity(), origin};
  }

  // True when the scene lies more than a thousand times its size from the
  // origin of the world. Float32 positions in the world frame would be off by
  // more than 6e-5 of the scene's size there.
  bool IsFarAway() const { return origin.norm() > 1000 * kTypicalDepth * unit; }
};

// A model as a file holds it: in world units, with positions that count from
// `offset`, a point of the world. It is zero except for scenes that are far
// away.
struct PlacedModel {
  GaussianModel model;
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();
};

// Rounds positions by at most 8e-6, or 2e-6 of themselves, and sizes by 3e-5 of
// themselves. This is far finer than a pixel and coarser than the rounding of a
// file in world units. So a model that was rounded, written and read is the
// same to the bit in any unit, as long as it lies at most about 20 times its
// size from the origin of the world.
void RoundToGrid(GaussianModel* model);

// Computed in double, then RoundToGrid. Values that float32 cannot hold become
// infinite.
GaussianModel ToFrame(const PlacedModel& placed, const ModelFrame& frame);

// The offset is the frame's origin if the frame is far away, else zero.
PlacedModel ToWorld(const GaussianModel& model, const ModelFrame& frame);

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_SCENE_MODEL_FRAME_H_
