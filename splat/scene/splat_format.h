// SPDX-License-Identifier: BSD-3-Clause
// The .splat format of web viewers (antimatter15/splat). It has 32 bytes per
// Gaussian, no header and no view-dependent colour.

#ifndef FREEGS_SPLAT_SCENE_SPLAT_FORMAT_H_
#define FREEGS_SPLAT_SCENE_SPLAT_FORMAT_H_

#include <filesystem>
#include <string>

#include "core/status.h"
#include "splat/scene/gaussian_model.h"

namespace freegs::splat {

// Returns one little-endian record per Gaussian:
//   3 x float32  position
//   3 x float32  standard deviations (not their logarithms)
//   4 x uint8    red, green, blue of the degree-0 colour, opacity; 255 is 1
//   4 x uint8    unit quaternion w x y z; a component c is stored as
//                round(c * 128 + 128), at most 255
// Records are sorted by volume times opacity, the largest first and ties by
// index: viewers draw while they download, so the Gaussians that cover most
// come first.
std::string SerializeSplat(const GaussianModel& model);

// Writes such a file, atomically.
Status WriteSplat(const std::filesystem::path& path,
                  const GaussianModel& model);

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_SCENE_SPLAT_FORMAT_H_
