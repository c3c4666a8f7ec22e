// SPDX-License-Identifier: BSD-3-Clause
// Chooses the Gaussians that a smaller model keeps by their importance (Fang
// and Wang 2024, Mini-Splatting, section 4.2). importance.h says what is
// important.

#ifndef FREEGS_SPLAT_DENSITY_SIMPLIFICATION_H_
#define FREEGS_SPLAT_DENSITY_SIMPLIFICATION_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace freegs::splat {

// All functions return indices of Gaussians in ascending order. They treat an
// importance that is negative or not finite as 0, and never choose a Gaussian
// of importance 0.

// Draws `count` indices without replacement, with probabilities in proportion
// to importance (the exponential keys of Efraimidis and Spirakis 2006). Returns
// all Gaussians that have any importance when there are no more than `count`.
// Random numbers are a function of seed, stream and index.
//
// A random choice keeps some of the less important Gaussians everywhere; the
// most important ones alone would leave holes.
std::vector<uint32_t> SampleByImportance(std::span<const float> importance,
                                         size_t count,
                                         uint64_t seed,
                                         uint64_t stream);

// Returns the most important Gaussians (ties by index), as few as together
// carry at least `share` of the total importance. A share of 1 or more gives
// all that have any importance, a share of 0 or less gives none. The last
// pruning of Mini-Splatting keeps 0.99.
std::vector<uint32_t> KeepCumulativeImportance(
    std::span<const float> importance, double share);

// Returns the `count` most important Gaussians (ties by index), or all that
// have any importance when there are no more than that.
std::vector<uint32_t> MostImportant(std::span<const float> importance,
                                    size_t count);

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_DENSITY_SIMPLIFICATION_H_
