// SPDX-License-Identifier: BSD-3-Clause
// Distances from one point to the sixteen entries of a k-d tree's node,
// vectorised.

#ifndef FREEGS_CORE_KD_TREE_SIMD_H_
#define FREEGS_CORE_KD_TREE_SIMD_H_

#include <cstdint>

namespace freegs {

// Entries of a block: the points of a leaf or the boxes of a node's children.
constexpr int kKdBlockSize = 16;

// What the kernels compute are lower bounds: float sums, made smaller by more
// than their rounding error, of the exact squared distances (in double, from
// the float coordinates), so that comparing one with the nearest float to a
// double is safe too. The relative error of the sum is at most about (dim + 2)
// * 2^-24, that of squares too small for a normal float is covered by
// kKdSlack.
constexpr float kKdSlack = 0x1p-120f;
constexpr float KdBoundFactor(int dim) {
  return 1.0f - static_cast<float>(dim < 64 ? 80 : dim + 16) * 0x1p-23f;
}

// Below this many times a distance a bound is less than it for sure; above, the
// two may be equal.
constexpr double KdTieFactor(int dim) {
  return 1.0 - 2 * (1.0 - static_cast<double>(KdBoundFactor(dim)));
}

// A float that is not above a squared distance.
constexpr float KdFloor(double distance2) {
  const float below = static_cast<float>(distance2 * (1 - 0x1p-22)) - kKdSlack;
  return below > 0 ? below : 0;
}

// Entries that do not count, and floors below which no entry's weight lies: a
// bound is the larger one of distance and floor.
struct KdBlockFilter {
  const uint32_t* components;  // kKdBlockSize; entries of `own` are left out.
  uint32_t own;
  const float* floors;  // kKdBlockSize.
};

// A bit per entry whose bound is at most the limit.
struct KdBlockBounds {
  uint32_t within = 0;
  float least_beyond = 0;  // Least bound above the limit; only with a filter.
};

// Bounds of the points of a leaf: block holds dim rows of kKdBlockSize
// coordinates; missing points are infinite.
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

// Bounds of boxes: block holds dim times kKdBlockSize lower and kKdBlockSize
// upper ends; missing boxes are infinite from above and below.
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
