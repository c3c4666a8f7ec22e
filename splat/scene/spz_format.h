// SPDX-License-Identifier: BSD-3-Clause
// The .spz format of Niantic: a compressed scene, about a tenth of its PLY, for
// web viewers and other programs.

#ifndef FREEGS_SPLAT_SCENE_SPZ_FORMAT_H_
#define FREEGS_SPLAT_SCENE_SPZ_FORMAT_H_

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

#include "core/status.h"
#include "splat/scene/gaussian_model.h"

namespace freegs::splat {

// Readers of the format's gzip versions accept no more Gaussians than this.
inline constexpr size_t kMaxSpzGaussians = 10'000'000;

// The logarithm of the largest deviation that the format has.
inline constexpr double kMaxSpzLogScale = 5.9375;

struct SpzOptions {
  // Coefficients of higher degrees are left out, which makes the file smaller.
  int sh_degree = kMaxShDegree;

  // The format's frame is x right, y up, z back; a scene of COLMAP's poses is
  // x right, y down, z forward. With true the scene is turned by half a turn
  // about x, as other programs do when they make .spz of such a PLY, so that it
  // stands upright in viewers. With false it is written in its own frame.
  bool flip_axes = true;
};

// Returns a file of version 3: a header of 16 bytes and then, each for all
// Gaussians, in the order of the model and all of it packed by gzip:
//   3 x int24   position; the header says how many bits are the fraction: as
//               many as make a step at most 1/4096 world units and at most
//               1/65536 of the median distance from the origin, or fewer where
//               a Gaussian lies too far away for that
//   uint8       opacity; 255 is 1
//   3 x uint8   red, green, blue: (0.5 + 0.15 * sh_dc) * 255
//   3 x uint8   log scale: (value + 10) * 16, so deviations are 4.5e-5 to 379
//   uint32      rotation: the place of the largest number of the quaternion
//               x y z w in 2 bits, the three others in 10 bits each
//   uint8       each coefficient of sh_rest, in the model's order: 128 * (value
//               + 1), with 5 significant bits for degree 1 and 4 above it
// What lies outside such a range gets the nearest value. Same model, same
// bytes. Fails with kBadInput for more than kMaxSpzGaussians Gaussians, for
// numbers that are not finite, and for positions of 2^23 and more.
StatusOr<std::string> SerializeSpz(const GaussianModel& model,
                                   const SpzOptions& options = {});

// Writes such a file for other programs, atomically. Fails with kBadInput also
// when more than one in a thousand of the Gaussians with an opacity of at least
// 0.05, and more than one of them, would show in another size: because it is
// larger than 379, or because a side below 4.5e-5 would grow to more than a
// tenth of its largest side.
Status WriteSpz(const std::filesystem::path& path,
                const GaussianModel& model,
                const SpzOptions& options = {});

// Reads version 2, whose rotations are x y z in a byte each with w >= 0, and
// version 3. With flip_axes the scene is turned back into COLMAP's frame, from
// the one that the extension SPZ_ADOBE_coordinate_system names, or else from x
// right, y up, z back. Without flip_axes it stays as it is in the file. Of
// degrees above 3 the coefficients are dropped. An opacity of 0 or 1 becomes
// one that is a quarter of a step away, because its logit would be infinite.
// Fails with kBadInput for other versions, for frames whose y is not up or
// down, and for content that is damaged, truncated, or longer than its header
// says. Memory is taken only for Gaussians that are there.
StatusOr<GaussianModel> ParseSpz(std::string_view bytes, bool flip_axes = true);

// The number of Gaussians that the header of a file of `file_bytes` names.
// `beginning` is the file or at least its first 64 KiB. Fails as ParseSpz does.
StatusOr<size_t> CountSpzGaussians(std::string_view beginning,
                                   uint64_t file_bytes);

// ParseSpz of a file. Messages name the file.
StatusOr<GaussianModel> ReadSpz(const std::filesystem::path& path);

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_SCENE_SPZ_FORMAT_H_
