// SPDX-License-Identifier: BSD-3-Clause
// Renders one picture of a trained scene.
//
//   render_scene SCENE.ply CAMERA.txt PICTURE.png
//
// CAMERA.txt holds numbers: width, height, fx, fy, cx and cy in pixels, then
// the 3 x 4 matrix that takes points of the world to the camera, row by row.
// The camera looks along z, x points right and y down.

#include <fstream>
#include <iostream>
#include <numeric>
#include <string>

#include "core/io/image_io.h"
#include "core/parallel.h"
#include "splat/render/renderer.h"
#include "splat/scene/ply_io.h"

namespace {

freegs::StatusOr<freegs::View> ReadCamera(const std::string& path) {
  std::ifstream file(path);
  freegs::View view;
  freegs::Pinhole& camera = view.camera;
  file >> camera.width >> camera.height >> camera.fx >> camera.fy >>
      camera.cx >> camera.cy;
  Eigen::Matrix3d rotation;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) file >> rotation(row, column);
    file >> view.cam_from_world.translation(row);
  }
  if (!file || camera.width < 1 || camera.height < 1 || camera.width > 8192 ||
      camera.height > 8192 || !(camera.fx > 0 && camera.fy > 0)) {
    return freegs::BadInputError(path + " is not a camera: 18 numbers");
  }
  view.cam_from_world.rotation = Eigen::Quaterniond(rotation).normalized();
  return view;
}

// Functions of freegs return what went wrong; nothing throws or prints.
freegs::Status Render(const std::string& scene_path,
                      const std::string& camera_path,
                      const std::string& picture_path) {
  FREEGS_ASSIGN_OR_RETURN(const freegs::splat::PlacedModel scene,
                          freegs::splat::ReadPly(scene_path));
  FREEGS_ASSIGN_OR_RETURN(freegs::View view, ReadCamera(camera_path));
  // Positions in the file count from its offset, which is 0 in most files.
  view.cam_from_world.translation +=
      view.cam_from_world.rotation * scene.offset;
  freegs::ThreadPool pool;
  const freegs::splat::RenderedView picture =
      freegs::splat::RenderView(scene.model,
                                view.camera,
                                view.cam_from_world,
                                freegs::splat::RenderOptions(),
                                pool);
  const freegs::ImageF& free = picture.transmittance;
  const double seen_through =
      std::accumulate(free.data(), free.data() + free.size(), 0.0) /
      free.size();
  std::cout << scene.model.size() << " Gaussians cover "
            << 100 * (1 - seen_through) << " % of " << picture_path << "\n";
  return freegs::WriteImage(picture_path, freegs::ToU8(picture.color));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) {
    std::cerr << "usage: render_scene SCENE.ply CAMERA.txt PICTURE.png\n";
    return 2;
  }
  const freegs::Status status = Render(argv[1], argv[2], argv[3]);
  if (status.ok()) return 0;
  std::cerr << "error: " << status.message() << "\n";
  return 3;
}
