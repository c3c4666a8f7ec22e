// SPDX-License-Identifier: BSD-3-Clause

#include "stages/disturb/disturb_poses.h"

#include <cmath>
#include <string>

#include <Eigen/Geometry>
#include <nlohmann/json.hpp>

#include "core/io/json_text.h"
#include "core/random.h"
#include "core/rigid3d.h"
#include "sfm/scene/model_io.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;

// Turns each camera so that what it saw at the centre of its picture moves by
// `pixels`, normally distributed in x and in y.
void TurnCameras(double pixels, uint64_t seed, sfm::Reconstruction* model) {
  const auto cameras = sfm::IndexCameras(*model);
  for (sfm::PosedImage& image : model->images) {
    const sfm::Camera& camera = model->cameras[cameras.at(image.camera_id)];
    // By the image's number, so that its turn does not depend on which others
    // there are.
    const double x = RandomNormal(seed, image.id, 0) * pixels;
    const double y = RandomNormal(seed, image.id, 1) * pixels;
    // The rotation that takes the z axis to the ray through that pixel.
    const Eigen::Vector3d ray =
        Eigen::Vector3d(x / camera.FocalX(), y / camera.FocalY(), 1)
            .normalized();
    const Eigen::Vector3d axis = Eigen::Vector3d::UnitZ().cross(ray);
    Rigid3d turn;
    turn.rotation.w() = 1 + ray.z();
    turn.rotation.vec() = axis;
    turn.rotation.normalize();
    image.cam_from_world = turn * image.cam_from_world;
  }
}

void MoveWorld(const Sim3d& new_from_old, sfm::Reconstruction* model) {
  for (sfm::PosedImage& image : model->images) {
    image.cam_from_world = TransformCamera(new_from_old, image.cam_from_world);
  }
  for (sfm::Point3D& point : model->points3d) {
    point.xyz = new_from_old * point.xyz;
  }
}

// Whether the model is one of a workspace, of poses that were imported without
// points.
bool HadNoPoints(const fs::path& model) {
  const auto health =
      ReadJson(model.parent_path().parent_path() / "health.json");
  if (!health.ok() || !health->is_object()) return false;
  const auto entry = health->find("source");
  if (entry == health->end() || !entry->is_string()) return false;
  const auto source = entry->get<std::string>();
  return source.starts_with("imported") &&
         (source.ends_with("points triangulated") ||
          source.ends_with("points random"));
}

}  // namespace

void DisturbModel(const Disturbance& disturbance,
                  uint64_t seed,
                  sfm::Reconstruction* model) {
  Sim3d new_from_old;
  switch (disturbance.kind) {
    case DisturbanceKind::kJitter:
      return TurnCameras(disturbance.amount, seed, model);
    case DisturbanceKind::kScale:
      new_from_old.scale = disturbance.amount;
      return MoveWorld(new_from_old, model);
    case DisturbanceKind::kMove:
      // Along no axis.
      new_from_old.translation =
          disturbance.amount * Eigen::Vector3d(2, -1, 2) / 3;
      return MoveWorld(new_from_old, model);
    default:
      return;
  }
}

Status DisturbPoses(const Disturbance& disturbance,
                    const std::filesystem::path& model,
                    const std::filesystem::path& out,
                    uint64_t seed) {
  FREEGS_ASSIGN_OR_RETURN(sfm::Reconstruction disturbed, sfm::ReadModel(model));
  if (HadNoPoints(model)) {
    disturbed.points3d.clear();
    for (sfm::PosedImage& image : disturbed.images) image.points2d.clear();
  }
  DisturbModel(disturbance, seed, &disturbed);
  FREEGS_RETURN_IF_ERROR(
      sfm::CheckReconstruction(disturbed).Annotated(model.string()));
  return sfm::WriteModel(out, disturbed);
}

}  // namespace freegs::stages
