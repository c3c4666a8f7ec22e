// SPDX-License-Identifier: BSD-3-Clause
// transforms.json, the camera file of instant-ngp, nerfstudio and the
// NeRF-synthetic scenes.

#ifndef FREEGS_SFM_IMPORT_TRANSFORMS_JSON_H_
#define FREEGS_SFM_IMPORT_TRANSFORMS_JSON_H_

#include <string>
#include <string_view>
#include <vector>

#include "core/rigid3d.h"
#include "core/status.h"
#include "sfm/scene/camera.h"

namespace freegs::sfm {

// Intrinsics as the file gives them; 0 stands for a value it does not give.
struct TransformsIntrinsics {
  double width = 0;    // Pixels.
  double height = 0;   // Pixels.
  double angle_x = 0;  // Horizontal field of view, radians.
  double angle_y = 0;  // Vertical field of view, radians.
  double fx = 0;       // Pixels.
  double fy = 0;       // Pixels.
  double cx = 0;       // Pixels; the top-left pixel's centre is (0.5, 0.5).
  double cy = 0;       // Pixels.
  bool has_centre = false;
  double k1 = 0, k2 = 0, k3 = 0, k4 = 0, p1 = 0, p2 = 0;
  bool fisheye = false;
};

struct TransformsFrame {
  std::string file_path;  // As written.
  TransformsIntrinsics intrinsics;

  // In the world of the file. The file has camera-to-world matrices with
  // OpenGL's camera axes (x right, y up, z backward): y and z are flipped here.
  Rigid3d cam_from_world;
};

// Parses the text of a transforms file. kBadInput names the frame and the
// fault: not JSON, missing fields, numbers that are not finite, a matrix that
// is not a rotation and translation, an unknown kind of camera.
StatusOr<std::vector<TransformsFrame>> ParseTransforms(std::string_view text);

// The camera for an image of width x height pixels, the size of the photo: the
// model is the simplest that holds the given distortion (PINHOLE, OPENCV,
// FULL_OPENCV, OPENCV_FISHEYE). Intrinsics of another size are scaled.
// kBadInput without a focal length or when the shapes differ by over 1 %.
StatusOr<Camera> MakeCamera(const TransformsIntrinsics& intrinsics,
                            int width,
                            int height);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_IMPORT_TRANSFORMS_JSON_H_
