// SPDX-License-Identifier: BSD-3-Clause
// Matches the features of two photos by their SIFT descriptors. Every
// descriptor of one photo is compared with every descriptor of the other.
// COLMAP itself searches approximately on a CPU, with random trees that it
// seeds with the machine's entropy, so that its matches differ from run to run.

#ifndef FREEGS_SFM_MATCHING_DESCRIPTOR_MATCHING_H_
#define FREEGS_SFM_MATCHING_DESCRIPTOR_MATCHING_H_

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/status.h"

namespace freegs::sfm {

inline constexpr size_t kSiftDimensions = 128;

// The descriptors of one photo, one after another.
struct SiftDescriptors {
  std::vector<uint8_t> values;  // count() x kSiftDimensions.
  size_t count() const { return values.size() / kSiftDimensions; }
};

// Returns the pairs (i in a, j in b), in the order of i, whose descriptors are
// each other's nearest and, in both directions, near enough and clearly nearer
// than the second nearest (Lowe, "Distinctive image features from
// scale-invariant keypoints", IJCV 2004, section 7.1). A descriptor whose two
// nearest are equally near matches none. Distances are angles between
// descriptors as vectors. The result does not depend on the processor.
std::vector<std::pair<uint32_t, uint32_t>> MatchDescriptors(
    const SiftDescriptors& a, const SiftDescriptors& b);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_MATCHING_DESCRIPTOR_MATCHING_H_
