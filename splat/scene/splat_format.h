// SPDX-License-Identifier: BSD-3-Clause
// The .splat format of web viewers (antimatter15/splat): 32 bytes per Gaussian,
// no header, no view-dependent colour.

#ifndef FREEGS_SPLAT_SCENE_SPLAT_FORMAT_H_
#define FREEGS_SPLAT_SCENE_SPLAT_FORMAT_H_

#include <filesystem>
#include <string>

#include "core/status.h"
#include "splat/scene/gaussian_model.h"

namespace freegs::splat {

// Record, little-endian: position 3 x float32; scale 3 x float32 (standard
// deviations, not their logs); colour 4 x uint8 (R G B of the degree-0 colour,
// opacity), 255 = 1; rotation 4 x uint8 (unit quaternion w x y z, each
// component c stored as round(c * 128 + 128) clamped to 255). Viewers draw
// while they download, so records are sorted by falling volume * opacity, ties
// by index.
std::string SerializeSplat(const GaussianModel& model);

// Writes atomically.
Status WriteSplat(const std::filesystem::path& path,
                  const GaussianModel& model);

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_SCENE_SPLAT_FORMAT_H_
