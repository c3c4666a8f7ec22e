// SPDX-License-Identifier: BSD-3-Clause
// Reads transforms.json, the camera file of instant-ngp, of nerfstudio and of
// the NeRF-synthetic scenes.

#ifndef FREEGS_SFM_IMPORT_TRANSFORMS_JSON_H_
#define FREEGS_SFM_IMPORT_TRANSFORMS_JSON_H_

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/rigid3d.h"
#include "core/status.h"
#include "sfm/scene/camera.h"

namespace freegs::sfm {

// Intrinsics as the file gives them. 0 stands for a value that it does not
// give, or gives as null; the centre is then empty.
struct TransformsIntrinsics {
  double width = 0;    // Pixels.
  double height = 0;   // Pixels.
  double angle_x = 0;  // Horizontal field of view, radians.
  double angle_y = 0;  // Vertical field of view, radians.
  double fx = 0;       // Pixels.
  double fy = 0;       // Pixels.

  // The centre in pixels; the top-left pixel's centre is (0.5, 0.5).
  std::optional<double> cx;
  std::optional<double> cy;

  double k1 = 0, k2 = 0, k3 = 0, k4 = 0, k5 = 0, k6 = 0, p1 = 0, p2 = 0;
  bool fisheye = false;
  bool full_opencv = false;  // The file says FULL_OPENCV: k4 to k6 are known.
};

struct TransformsFrame {
  // As written, from the folder of the file; it may lead anywhere. Only to be
  // compared with names of photos, never to be opened.
  std::string file_path;
  TransformsIntrinsics intrinsics;

  // The pose in the world of the file. The file has camera-to-world matrices
  // with the camera axes of OpenGL (x right, y up, z backward); here the camera
  // frame is that of the rest of the program (x right, y down, z forward).
  Rigid3d cam_from_world;
};

struct TransformsFile {
  std::vector<TransformsFrame> frames;

  // nerfstudio's "test_filenames" and "val_filenames": frames that are meant
  // for evaluation, as written.
  std::vector<std::string> holdout;

  // Whether a frame, or the whole file, has a "mask_path".
  bool names_masks = false;

  // nerfstudio's file of points, "ply_file_path", as written. Empty if there is
  // none.
  std::string points_file;
};

// Parses the text of a transforms file. A frame inherits what it does not give
// from the file. Its fields of view and focal lengths (fl_x, fl_y,
// camera_angle_x, camera_angle_y, x_fov, y_fov) are inherited together: if it
// gives one of them, none of the file's counts. Of an axis that has several,
// the focal length counts, then x_fov or y_fov (degrees), then the angle
// (radians). Returns kBadInput, with the frame and
// the fault, for text that is not JSON, missing fields, numbers that are not
// finite, matrices that are not a rotation and a translation, and unknown kinds
// of cameras.
StatusOr<TransformsFile> ParseTransforms(std::string_view text);

// Returns the camera for a photo of width x height pixels. Its model is the
// simplest of PINHOLE, OPENCV, FULL_OPENCV and OPENCV_FISHEYE that has the
// given distortion parameters. Intrinsics for another image size are scaled. A
// focal length or field of view of one axis alone gives the focal length of
// both. A coordinate of the centre that is not given is that of the middle.
// Returns kBadInput when there is no focal length, when the two sizes are not
// those of one image that was resized (see IsResized), and for distortion that
// the kind of camera does not have: k4, k5 and k6 of one that is neither a
// fisheye nor FULL_OPENCV, and p1, p2, k5 and k6 of a fisheye.
StatusOr<Camera> MakeCamera(const TransformsIntrinsics& intrinsics,
                            int width,
                            int height);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_IMPORT_TRANSFORMS_JSON_H_
