// SPDX-License-Identifier: BSD-3-Clause
// COLMAP's camera models by number and name, and the parameters each one has.

#ifndef FREEGS_SFM_SCENE_CAMERA_MODEL_H_
#define FREEGS_SFM_SCENE_CAMERA_MODEL_H_

#include <array>
#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

#include "core/status.h"

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

  // Whether a pixel without distortion is as far from the centre as the angle
  // between ray and axis tells, and not as the tangent of this angle.
  bool fisheye;
};

// All models, ordered by number. Also templates ask this table.
inline constexpr std::array<CameraModelInfo, 11> kCameraModels = {{
    {CameraModel::kSimplePinhole, "SIMPLE_PINHOLE", 3, 1, false},
    {CameraModel::kPinhole, "PINHOLE", 4, 2, false},
    {CameraModel::kSimpleRadial, "SIMPLE_RADIAL", 4, 1, false},
    {CameraModel::kRadial, "RADIAL", 5, 1, false},
    {CameraModel::kOpenCv, "OPENCV", 8, 2, false},
    {CameraModel::kOpenCvFisheye, "OPENCV_FISHEYE", 8, 2, true},
    {CameraModel::kFullOpenCv, "FULL_OPENCV", 12, 2, false},
    {CameraModel::kFov, "FOV", 5, 2, false},
    {CameraModel::kSimpleRadialFisheye, "SIMPLE_RADIAL_FISHEYE", 4, 1, true},
    {CameraModel::kRadialFisheye, "RADIAL_FISHEYE", 5, 1, true},
    {CameraModel::kThinPrismFisheye, "THIN_PRISM_FISHEYE", 12, 2, true},
}};

inline std::span<const CameraModelInfo> CameraModels() { return kCameraModels; }

// Return null when COLMAP's number or name is not known.
const CameraModelInfo* FindCameraModel(int id);
const CameraModelInfo* FindCameraModel(std::string_view name);

// How a camera of COLMAP's files is read. Newer releases than 3.8 have models
// that the table lacks. Of these SIMPLE_FISHEYE (f cx cy) and FISHEYE (fx fy cx
// cy), fisheyes without distortion, are read as OPENCV_FISHEYE.
struct StoredCameraModel {
  CameraModel model = CameraModel::kPinhole;
  int num_params = 0;  // In the file.
};

// Fail with kBadInput for numbers and names that are unknown or not supported.
StatusOr<StoredCameraModel> FindStoredCameraModel(int id);
StatusOr<StoredCameraModel> FindStoredCameraModel(std::string_view name);

// Brings the parameters of a file, stored.num_params of them, to those of
// stored.model.
void CompleteParameters(const StoredCameraModel& stored,
                        std::vector<double>* params);

constexpr const CameraModelInfo& GetCameraModel(CameraModel model) {
  return kCameraModels[static_cast<size_t>(model)];
}

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_SCENE_CAMERA_MODEL_H_
