// SPDX-License-Identifier: BSD-3-Clause
// Converts COLMAP's binary model files (little-endian, packed) from and to
// memory.

#ifndef FREEGS_SFM_SCENE_MODEL_IO_BINARY_H_
#define FREEGS_SFM_SCENE_MODEL_IO_BINARY_H_

#include <string>
#include <string_view>
#include <vector>

#include "core/status.h"
#include "sfm/scene/reconstruction.h"

namespace freegs::sfm {

// Each function parses a whole file into a list, which must be empty. Returns
// kBadInput when the file is truncated, has bytes left over, or claims more
// items than its size allows. It takes no more memory than a small multiple of
// the size of `bytes`.
Status ParseCamerasBinary(std::string_view bytes, std::vector<Camera>* cameras);
Status ParseImagesBinary(std::string_view bytes,
                         std::vector<PosedImage>* images);
Status ParsePointsBinary(std::string_view bytes, std::vector<Point3D>* points);

std::string CamerasToBinary(const std::vector<Camera>& cameras);
std::string ImagesToBinary(const std::vector<PosedImage>& images);
std::string PointsToBinary(const std::vector<Point3D>& points);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_SCENE_MODEL_IO_BINARY_H_
