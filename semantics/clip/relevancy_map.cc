// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/clip/relevancy_map.h"

#include <algorithm>
#include <cstdint>
#include <vector>

#include "semantics/clip/relevancy.h"

namespace freegs::semantics {
namespace {

// The number of upsampled values that are in memory at a time.
constexpr size_t kBlockValues = size_t{1} << 22;
constexpr int64_t kMapPixelGrain = 256;

}  // namespace

StatusOr<ImageF> RelevancyMap(const ImageF& features,
                              const ImageF& guide,
                              std::span<const float> text,
                              std::span<const float> canonical,
                              const JointBilateralOptions& options,
                              ThreadPool& pool) {
  const auto dim = static_cast<size_t>(features.channels());
  if (dim == 0 || text.size() != dim || canonical.size() % dim != 0) {
    return InvalidArgumentError(
        "texts and features of a relevancy map differ in size");
  }
  ImageF relevancy(guide.width(), guide.height(), 1);
  const size_t block = std::max<size_t>(1, kBlockValues / dim);
  const auto width = static_cast<size_t>(guide.width());
  std::vector<PixelIndex> pixels;
  size_t first = 0;
  do {
    const size_t last = std::min(guide.num_pixels(), first + block);
    pixels.clear();
    for (size_t k = first; k < last; ++k) {
      pixels.push_back(
          {static_cast<int>(k % width), static_cast<int>(k / width)});
    }
    FREEGS_ASSIGN_OR_RETURN(
        const std::vector<float> upsampled,
        JointBilateralUpsampleAt(features, guide, pixels, options, pool));
    pool.ParallelFor(
        0,
        static_cast<int64_t>(pixels.size()),
        kMapPixelGrain,
        [&](int64_t begin, int64_t end, int) {
          for (auto k = static_cast<size_t>(begin);
               k < static_cast<size_t>(end);
               ++k) {
            relevancy.data()[first + k] =
                Relevancy({upsampled.data() + k * dim, dim}, text, canonical);
          }
        });
    first = last;
  } while (first < guide.num_pixels());
  return relevancy;
}

}  // namespace freegs::semantics
