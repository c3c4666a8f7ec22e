// SPDX-License-Identifier: BSD-3-Clause
// Which features of two photos have the same SIFT descriptor. Exact: every
// descriptor is compared with every other. (COLMAP on a CPU searches
// approximately, with a forest of random trees seeded by the machine's entropy:
// its matches differ from run to run.)

#ifndef FREEGS_SFM_MATCHING_DESCRIPTOR_MATCHING_H_
#define FREEGS_SFM_MATCHING_DESCRIPTOR_MATCHING_H_

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/status.h"

namespace freegs::sfm {

inline constexpr size_t kSiftDimensions = 128;

// Descriptors of one photo, one after another.
struct SiftDescriptors {
  std::vector<uint8_t> values;  // count() x kSiftDimensions.
  size_t count() const { return values.size() / kSiftDimensions; }
};

struct DescriptorMatchingOptions {
  // The angle to the nearest descriptor must be below this share of the angle
  // to the second nearest (Lowe, "Distinctive image features from
  // scale-invariant keypoints", IJCV 2004, section 7.1).
  double max_ratio = 0.8;

  // Largest angle between two descriptors, radians.
  double max_angle = 0.7;

  Status Check() const;
};

// Pairs (i in a, j in b), by ascending i, whose descriptors are each other's
// nearest, pass both tests in both directions, and have no equals. Angles are
// those between the descriptors as vectors. The result does not depend on the
// processor.
std::vector<std::pair<uint32_t, uint32_t>> MatchDescriptors(
    const SiftDescriptors& a,
    const SiftDescriptors& b,
    const DescriptorMatchingOptions& options);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_MATCHING_DESCRIPTOR_MATCHING_H_
