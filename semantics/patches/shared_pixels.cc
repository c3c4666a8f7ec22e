// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/patches/shared_pixels.h"

#include <algorithm>
#include <utility>

namespace freegs::semantics {
namespace {

// The pixels of each region.
std::vector<double> SizesOf(std::span<const int32_t> region_of_gaussian,
                            std::span<const double> seen) {
  std::vector<double> sizes;
  for (size_t g = 0; g < region_of_gaussian.size(); ++g) {
    const int32_t region = region_of_gaussian[g];
    if (region < 0) continue;
    if (static_cast<size_t>(region) >= sizes.size()) sizes.resize(region + 1);
    sizes[region] += seen[g];
  }
  return sizes;
}

}  // namespace

std::vector<SharedPixels> FindSharedPixels(std::span<const int32_t> a,
                                           std::span<const int32_t> b,
                                           std::span<const double> seen) {
  // Sorted by Gaussians as well, so that sums do not depend on the sorting.
  std::vector<std::pair<uint64_t, uint32_t>> gaussians;
  gaussians.reserve(a.size());
  for (size_t g = 0; g < a.size(); ++g) {
    if (a[g] < 0 || b[g] < 0 || !(seen[g] > 0)) continue;
    gaussians.emplace_back(
        static_cast<uint64_t>(a[g]) << 32 | static_cast<uint32_t>(b[g]),
        static_cast<uint32_t>(g));
  }
  std::sort(gaussians.begin(), gaussians.end());
  std::vector<SharedPixels> shared;
  uint64_t last = ~uint64_t{0};
  for (const auto& [key, g] : gaussians) {
    if (key != last) {
      shared.push_back({static_cast<int32_t>(key >> 32),
                        static_cast<int32_t>(key & 0xffffffff),
                        0});
      last = key;
    }
    shared.back().pixels += seen[g];
  }
  return shared;
}

PatchPixels PixelsOfPatches(std::span<const SharedPixels> shared,
                            int num_a,
                            int num_b) {
  PatchPixels result;
  result.of_a.assign(num_a, 0.0);
  result.of_b.assign(num_b, 0.0);
  result.first_of_a.assign(num_a + 1, 0);
  for (const SharedPixels& pair : shared) {
    result.of_a[pair.a] += pair.pixels;
    result.of_b[pair.b] += pair.pixels;
    ++result.first_of_a[pair.a + 1];
  }
  for (int p = 0; p < num_a; ++p) {
    result.first_of_a[p + 1] += result.first_of_a[p];
  }
  return result;
}

double Agreement(std::span<const int32_t> a,
                 std::span<const int32_t> b,
                 std::span<const double> seen) {
  const std::vector<double> sizes_a = SizesOf(a, seen);
  const std::vector<double> sizes_b = SizesOf(b, seen);
  std::vector<double> best(sizes_a.size(), 0.0);
  for (const SharedPixels& pair : FindSharedPixels(a, b, seen)) {
    const double either = sizes_a[pair.a] + sizes_b[pair.b] - pair.pixels;
    best[pair.a] = std::max(best[pair.a], pair.pixels / either);
  }
  double sum = 0;
  for (size_t region = 0; region < best.size(); ++region) {
    sum += sizes_a[region] * best[region];
  }
  double pixels = 0;
  for (size_t g = 0; g < seen.size(); ++g) {
    if (a[g] >= 0 || b[g] >= 0) pixels += seen[g];
  }
  return pixels > 0 ? sum / pixels : 0;
}

}  // namespace freegs::semantics
