// SPDX-License-Identifier: BSD-3-Clause
// Distances from one point to the sixteen entries of a node of a k-d tree, for
// all entries at once.

#ifndef FREEGS_CORE_KD_TREE_SIMD_H_
#define FREEGS_CORE_KD_TREE_SIMD_H_

#include <cstdint>

namespace freegs {

// A block has so many entries: the points of a leaf, or the bounding boxes of a
// node's children.
inline constexpr int kKdBlockSize = 16;

// The kernels compute lower bounds of squared distances. They add squares in
// float and then make the sum smaller, by more than its rounding error. So a
// bound never exceeds the exact squared distance (the sum in double of the
// float coordinates), not even when that is rounded to a float. The relative
// rounding error is at most about (dim + 2) * 2^-24, and KdBoundFactor removes
// more than that. kKdSlack covers squares that are too small for a normal
// float.
inline constexpr float kKdSlack = 0x1p-120f;
constexpr float KdBoundFactor(int dim) {
  return 1.0f - static_cast<float>(dim < 64 ? 80 : dim + 16) * 0x1p-23f;
}

// A bound below this factor times a squared distance belongs to an entry that
// is nearer than that distance for sure. Above the factor, the two may be
// equal.
constexpr double KdTieFactor(int dim) {
  return 1.0 - 2 * (1.0 - static_cast<double>(KdBoundFactor(dim)));
}

// A float that is at most the given squared distance.
constexpr float KdFloor(double distance2) {
  const float below = static_cast<float>(distance2 * (1 - 0x1p-22)) - kKdSlack;
  return below > 0 ? below : 0;
}

// Leaves entries out, and raises the bounds of the others. Entries whose
// component is `own` are left out. The bound of an entry becomes the larger one
// of its distance bound and its floor. Both arrays have kKdBlockSize values.
struct KdBlockFilter {
  const uint32_t* components;
  uint32_t own;
  const float* floors;
};

struct KdBlockBounds {
  uint32_t within = 0;     // Bit i is set when bound i is at most the limit.
  float least_beyond = 0;  // The least of the bounds above the limit.
};

// Computes the bounds of the points of a leaf. `block` holds dim rows of
// kKdBlockSize coordinates; those of missing points are infinite. Without a
// filter only the bits of KdBlockBounds::within are returned.
uint32_t KdPointBounds(const float* block,
                       int dim,
                       const float* query,
                       float limit,
                       float bounds[kKdBlockSize]);
KdBlockBounds KdPointBounds(const float* block,
                            int dim,
                            const float* query,
                            const KdBlockFilter& filter,
                            float limit,
                            float bounds[kKdBlockSize]);

// Does the same for boxes. For each dimension `block` holds kKdBlockSize lower
// ends and then kKdBlockSize upper ends; missing boxes have the lower end at
// infinity and the upper end at minus infinity.
uint32_t KdBoxBounds(const float* block,
                     int dim,
                     const float* query,
                     float limit,
                     float bounds[kKdBlockSize]);
KdBlockBounds KdBoxBounds(const float* block,
                          int dim,
                          const float* query,
                          const KdBlockFilter& filter,
                          float limit,
                          float bounds[kKdBlockSize]);

}  // namespace freegs

#endif  // FREEGS_CORE_KD_TREE_SIMD_H_
