// SPDX-License-Identifier: BSD-3-Clause
// Which pixels the patches, or regions, of two divisions of one scene have in
// common.

#ifndef FREEGS_SEMANTICS_PATCHES_SHARED_PIXELS_H_
#define FREEGS_SEMANTICS_PATCHES_SHARED_PIXELS_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace freegs::semantics {

struct SharedPixels {
  int32_t a = 0;  // A patch of the first division.
  int32_t b = 0;  // One of the second.
  double pixels = 0;
};

// a, b: the patch of each Gaussian, -1 for none. seen: how many pixels each
// Gaussian covers. Returns each pair of patches with a Gaussian in common once,
// sorted by (a, b).
std::vector<SharedPixels> FindSharedPixels(std::span<const int32_t> a,
                                           std::span<const int32_t> b,
                                           std::span<const double> seen);

// What each patch shares with all of the other division together.
struct PatchPixels {
  std::vector<double> of_a;
  std::vector<double> of_b;
  // The pairs of patch p of the first division are those from first_of_a[p] to
  // first_of_a[p + 1] - 1.
  std::vector<size_t> first_of_a;
};

// shared: sorted as FindSharedPixels returns it. num_a, num_b: the numbers of
// patches in both divisions.
PatchPixels PixelsOfPatches(std::span<const SharedPixels> shared,
                            int num_a,
                            int num_b);

// How much two divisions of the Gaussians, given as above, are alike: the mean,
// over the pixels that are of a region in either, of the largest intersection
// over union of their region in the first with one in the second. Pixels that
// are of no region in the first count as 0, so that leaving things to nobody
// gains nothing. 0 without shared pixels.
double Agreement(std::span<const int32_t> a,
                 std::span<const int32_t> b,
                 std::span<const double> seen);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_PATCHES_SHARED_PIXELS_H_
