// SPDX-License-Identifier: BSD-3-Clause
// COLMAP's text model files, from and to memory.

#ifndef FREEGS_SFM_SCENE_MODEL_IO_TEXT_H_
#define FREEGS_SFM_SCENE_MODEL_IO_TEXT_H_

#include <string>
#include <string_view>
#include <vector>

#include "core/status.h"
#include "sfm/scene/reconstruction.h"

namespace freegs::sfm {

// Each parses a whole file and appends to an empty list. Lines that start with
// '#' are comments. In an images file each image takes two lines, the second
// of which (its features) may be empty; the name is the rest of the first line,
// spaces included. kBadInput names the line. Numbers are read the same way in
// every locale.
Status ParseCamerasText(std::string_view text, std::vector<Camera>* cameras);
Status ParseImagesText(std::string_view text, std::vector<PosedImage>* images);
Status ParsePointsText(std::string_view text, std::vector<Point3D>* points);

// Numbers are written so that reading them gives the same value.
std::string CamerasToText(const std::vector<Camera>& cameras);
std::string ImagesToText(const std::vector<PosedImage>& images);
std::string PointsToText(const std::vector<Point3D>& points);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_SCENE_MODEL_IO_TEXT_H_
