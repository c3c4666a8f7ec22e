// SPDX-License-Identifier: BSD-3-Clause
// PLY files in the layout that 3D Gaussian Splatting programs share.

#ifndef FREEGS_SPLAT_SCENE_PLY_IO_H_
#define FREEGS_SPLAT_SCENE_PLY_IO_H_

#include <filesystem>
#include <string>
#include <string_view>

#include <Eigen/Core>

#include "core/status.h"
#include "splat/scene/gaussian_model.h"
#include "splat/scene/model_frame.h"

namespace freegs::splat {

// The vertex properties are x y z nx ny nz f_dc_0..2 f_rest_* opacity
// scale_0..2 rot_0..3. Scales are natural logarithms, opacity is a logit, and
// the quaternion is w x y z. In files f_rest is channel-major,
// f_rest_[channel * (K - 1) + k] with K = (degree + 1)^2, while a GaussianModel
// is coefficient-major. Normals are ignored when read and written as zeros. An
// offset other than zero (see PlacedModel) is a header line "comment offset X Y
// Z", which other programs ignore: to them the scene lies near the origin. An
// antialiased model has a line "comment SplatRenderMode: mip", which other
// programs know.

// Reads binary files of either byte order, and ascii files. The properties may
// come in any order and have any numeric type. A property filter_3D, the
// standard deviation f of the 3D filter of Mip-Splatting (Yu et al. 2024) in
// world units, is fused: each variance s^2 becomes s^2 + f^2, and opacity is
// multiplied by sqrt(prod s^2 / prod (s^2 + f^2)). Other properties and other
// elements are skipped. The SH degree follows from the number of f_rest
// properties (0, 9, 24, 45 or 72); of degree 4 the coefficients above degree 3
// are dropped. Fails with kBadInput, naming the file and the fault, when a
// property is missing, when the content is shorter than the header says, or
// when values are not finite (the message says in how many vertices). The
// compressed .ply files of SuperSplat (element "chunk") are refused as such.
StatusOr<PlacedModel> ReadPly(const std::filesystem::path& path);

// Like ReadPly, but from the content of a file. Messages do not name the file.
StatusOr<PlacedModel> ParsePly(std::string_view content);

// Writes a binary_little_endian file of float32 properties, atomically.
Status WritePly(const std::filesystem::path& path,
                const GaussianModel& model,
                const Eigen::Vector3d& offset = Eigen::Vector3d::Zero());

// The header line that names the offset, or nothing for zero.
std::string PlyOffsetLine(const Eigen::Vector3d& offset);

// Returns the content that WritePly writes.
std::string SerializePly(
    const GaussianModel& model,
    const Eigen::Vector3d& offset = Eigen::Vector3d::Zero());

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_SCENE_PLY_IO_H_
