// SPDX-License-Identifier: BSD-3-Clause
// Converts COLMAP's text model files from and to memory.

#ifndef FREEGS_SFM_SCENE_MODEL_IO_TEXT_H_
#define FREEGS_SFM_SCENE_MODEL_IO_TEXT_H_

#include <string>
#include <string_view>
#include <vector>

#include "core/status.h"
#include "sfm/scene/reconstruction.h"

namespace freegs::sfm {

// Each function parses a whole file into a list, which must be empty. Lines
// that begin with '#' are comments. In an images file each image has two lines.
// The first ends with the name, which may contain spaces; the second, with the
// features, may be empty. The message of kBadInput names the line. Numbers are
// read in the same way in every locale.
Status ParseCamerasText(std::string_view text, std::vector<Camera>* cameras);
Status ParseImagesText(std::string_view text, std::vector<PosedImage>* images);
Status ParsePointsText(std::string_view text, std::vector<Point3D>* points);

// Numbers are written so that they read back as the same values.
std::string CamerasToText(const std::vector<Camera>& cameras);
std::string ImagesToText(const std::vector<PosedImage>& images);
std::string PointsToText(const std::vector<Point3D>& points);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_SCENE_MODEL_IO_TEXT_H_
