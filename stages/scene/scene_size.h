// SPDX-License-Identifier: BSD-3-Clause
// The sizes of a scene that decide how much memory a stage needs.

#ifndef FREEGS_STAGES_SCENE_SCENE_SIZE_H_
#define FREEGS_STAGES_SCENE_SCENE_SIZE_H_

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>

#include "core/pinhole.h"

namespace freegs::stages {

// Pixels of all views, and of the largest one, when their longest sides are
// limited to max_side (0: they are not).
struct ViewPixels {
  int64_t total = 0;
  int64_t largest = 0;
};
ViewPixels CountPixels(std::span<const View> views, int max_side);

// The number of Gaussians that the header of a PLY file names; nothing when it
// cannot be read.
std::optional<int64_t> CountGaussians(const std::filesystem::path& ply);

// What a trained model takes that is read, moved to another frame and written:
// the arrays of the model (59 floats with SH degree 3) three times.
inline constexpr int64_t kBytesPerReadGaussian = 3 * 59 * 4;

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_SCENE_SCENE_SIZE_H_
