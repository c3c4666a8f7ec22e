// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/metrics/boundary_iou.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "semantics/metrics/instance_metrics.h"

namespace freegs::semantics {
namespace {

// Share of the image's diagonal that a boundary is wide: the value of the paper
// and of the LERF-Mask benchmark (Ye et al. 2024).
constexpr double kBoundaryRatio = 0.02;

// Sets to 0 what is within `distance` pixels of a 0 along one line of the
// image: `count` pixels `stride` apart, with zeros beyond both ends. `scratch`
// is memory to reuse.
void ErodeLine(uint8_t* line,
               int count,
               size_t stride,
               int distance,
               std::vector<int>* scratch) {
  // For each pixel: the index of the last 0 at or before it.
  scratch->resize(static_cast<size_t>(count));
  int last = -1;
  for (int i = 0; i < count; ++i) {
    if (line[static_cast<size_t>(i) * stride] == 0) last = i;
    (*scratch)[static_cast<size_t>(i)] = last;
  }
  int next = count;
  for (int i = count - 1; i >= 0; --i) {
    uint8_t& value = line[static_cast<size_t>(i) * stride];
    if (value == 0) next = i;
    const int before = (*scratch)[static_cast<size_t>(i)];
    if (std::min(i - before, next - i) <= distance) value = 0;
  }
}

}  // namespace

int BoundaryWidth(int width, int height) {
  const double diagonal =
      std::hypot(static_cast<double>(width), static_cast<double>(height));
  return std::max(1, static_cast<int>(std::lround(kBoundaryRatio * diagonal)));
}

StatusOr<ImageU8> MaskBoundary(const ImageU8& mask, int distance) {
  if (mask.channels() != 1) {
    return InvalidArgumentError("a mask must have one channel");
  }
  if (distance < 1) {
    return InvalidArgumentError("a boundary must be at least one pixel wide");
  }
  // Erosion by a square is erosion by a row and then by a column.
  ImageU8 inner = mask;
  std::vector<int> scratch;
  for (int y = 0; y < mask.height(); ++y) {
    ErodeLine(inner.row(y), mask.width(), 1, distance, &scratch);
  }
  for (int x = 0; x < mask.width(); ++x) {
    ErodeLine(inner.data() + x,
              mask.height(),
              static_cast<size_t>(mask.width()),
              distance,
              &scratch);
  }
  for (size_t i = 0; i < inner.size(); ++i) {
    const bool boundary = mask.data()[i] != 0 && inner.data()[i] == 0;
    inner.data()[i] = boundary ? 255 : 0;
  }
  return inner;
}

StatusOr<double> BoundaryIou(const ImageU8& a, const ImageU8& b) {
  const int distance = BoundaryWidth(a.width(), a.height());
  FREEGS_ASSIGN_OR_RETURN(const ImageU8 boundary_a, MaskBoundary(a, distance));
  FREEGS_ASSIGN_OR_RETURN(const ImageU8 boundary_b, MaskBoundary(b, distance));
  return MaskIou(boundary_a, boundary_b);
}

}  // namespace freegs::semantics
