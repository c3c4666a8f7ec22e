// SPDX-License-Identifier: BSD-3-Clause
// The identity-coupled semantic field (IDSF) of FreeGS: a semantic vector and
// an instance index for every Gaussian.

#ifndef FREEGS_SEMANTICS_FIELD_IDSF_H_
#define FREEGS_SEMANTICS_FIELD_IDSF_H_

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/status.h"

namespace freegs::semantics {

// Entries are in the order of the Gaussians of the scene.
struct Idsf {
  int feature_dim = 0;          // D; 0 if there are no semantics.
  std::vector<float> features;  // N x D, row-major.
  // N; -1 for none, else instance id - 1, which is below N: an instance has one
  // Gaussian at least.
  std::vector<int32_t> instances;
};

// The file, little-endian:
//   8 bytes   "FREEGSID"
//   uint32    version, 1
//   uint32    D
//   uint64    N
//   int32     N instance indices, each in -1 .. N - 1
//   float32   N x D features
//   uint64    XXH3 of everything before
// kInvalidArgument when the arrays' sizes disagree.
Status WriteIdsf(const std::filesystem::path& path, const Idsf& idsf);
StatusOr<std::string> SerializeIdsf(const Idsf& idsf);

// kBadInput, which names the file and the fault, for anything but a complete
// file of a known version with a matching checksum, and for features that are
// not finite.
StatusOr<Idsf> ReadIdsf(const std::filesystem::path& path);
StatusOr<Idsf> ParseIdsf(std::string_view content);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_FIELD_IDSF_H_
