// SPDX-License-Identifier: BSD-3-Clause
// How large a trained model is, in a file and in memory.

#ifndef FREEGS_STAGES_SCENE_SCENE_SIZE_H_
#define FREEGS_STAGES_SCENE_SCENE_SIZE_H_

#include <cstdint>
#include <filesystem>
#include <optional>

namespace freegs::stages {

// The number of Gaussians that the header of a .ply or .spz file names; nothing
// when it cannot be read.
std::optional<int64_t> CountGaussians(const std::filesystem::path& path);

// What a trained model takes that is read, moved to another frame and written:
// the arrays of the model (59 floats with SH degree 3) three times.
inline constexpr int64_t kBytesPerReadGaussian = 3 * 59 * 4;

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_SCENE_SCENE_SIZE_H_
