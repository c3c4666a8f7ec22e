// SPDX-License-Identifier: BSD-3-Clause
// COLMAP's camera models by number and name, and the parameters each one has.

#ifndef FREEGS_SFM_SCENE_CAMERA_MODEL_H_
#define FREEGS_SFM_SCENE_CAMERA_MODEL_H_

#include <span>
#include <string_view>

namespace freegs::sfm {

// The numbers are those of COLMAP's binary files. The comments name the
// parameters in order: f is a focal length and c the principal point, both in
// pixels; the others are distortion parameters.
enum class CameraModel : int {
  kSimplePinhole = 0,        // f cx cy
  kPinhole = 1,              // fx fy cx cy
  kSimpleRadial = 2,         // f cx cy k
  kRadial = 3,               // f cx cy k1 k2
  kOpenCv = 4,               // fx fy cx cy k1 k2 p1 p2
  kOpenCvFisheye = 5,        // fx fy cx cy k1 k2 k3 k4
  kFullOpenCv = 6,           // fx fy cx cy k1 k2 p1 p2 k3 k4 k5 k6
  kFov = 7,                  // fx fy cx cy omega
  kSimpleRadialFisheye = 8,  // f cx cy k
  kRadialFisheye = 9,        // f cx cy k1 k2
  kThinPrismFisheye = 10,    // fx fy cx cy k1 k2 p1 p2 k3 k4 sx1 sy1
};

struct CameraModelInfo {
  CameraModel model;
  std::string_view name;  // As in COLMAP's text models: "SIMPLE_RADIAL".
  int num_params;
  int num_focal;  // 1, for x and y together, or 2.
};

// All models, ordered by number.
std::span<const CameraModelInfo> CameraModels();

// Return null when COLMAP's number or name is not known.
const CameraModelInfo* FindCameraModel(int id);
const CameraModelInfo* FindCameraModel(std::string_view name);
const CameraModelInfo& GetCameraModel(CameraModel model);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_SCENE_CAMERA_MODEL_H_
