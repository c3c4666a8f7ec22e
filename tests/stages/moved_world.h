// SPDX-License-Identifier: BSD-3-Clause
// Changes the world frame of a workspace: its unit and its origin.

#ifndef FREEGS_TESTS_STAGES_MOVED_WORLD_H_
#define FREEGS_TESTS_STAGES_MOVED_WORLD_H_

#include <filesystem>

#include <gtest/gtest.h>

#include "sfm/scene/model_io.h"
#include "splat/scene/ply_io.h"
#include "stages/scene/workspace_scene.h"

namespace freegs::stages {

// Rounds reconstruct/point_cloud.ply as stage reconstruct does.
inline void RoundModel(const std::filesystem::path& workspace) {
  const StatusOr<WorkspaceScene> scene = ReadWorkspaceScene(workspace);
  ASSERT_TRUE(scene.ok()) << scene.status().message();
  const splat::PlacedModel world = splat::ToWorld(scene->model, scene->frame);
  ASSERT_TRUE(splat::WritePly(workspace / "reconstruct" / "point_cloud.ply",
                              world.model,
                              world.offset)
                  .ok());
}

// x becomes scale * x + shift in undistort/sparse and, where it is there, in
// reconstruct/point_cloud.ply.
inline void MoveWorld(const std::filesystem::path& workspace,
                      double scale,
                      const Eigen::Vector3d& shift) {
  const Sim3d moved_from_world = {scale, Eigen::Quaterniond::Identity(), shift};
  const std::filesystem::path folder = workspace / "undistort" / "sparse";
  StatusOr<sfm::Reconstruction> sparse = sfm::ReadModel(folder);
  ASSERT_TRUE(sparse.ok()) << sparse.status().message();
  for (sfm::PosedImage& image : sparse->images) {
    image.cam_from_world =
        TransformCamera(moved_from_world, image.cam_from_world);
  }
  for (sfm::Point3D& point : sparse->points3d) {
    point.xyz = moved_from_world * point.xyz;
  }
  ASSERT_TRUE(sfm::WriteModel(folder, *sparse).ok());
  const std::filesystem::path ply =
      workspace / "reconstruct" / "point_cloud.ply";
  if (!std::filesystem::exists(ply)) return;
  const StatusOr<splat::PlacedModel> old = splat::ReadPly(ply);
  ASSERT_TRUE(old.ok());
  const splat::PlacedModel moved = splat::ToWorld(old->model, {shift, scale});
  ASSERT_TRUE(splat::WritePly(ply, moved.model, moved.offset).ok());
}

}  // namespace freegs::stages

#endif  // FREEGS_TESTS_STAGES_MOVED_WORLD_H_
