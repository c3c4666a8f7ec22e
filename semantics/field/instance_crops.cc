// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/field/instance_crops.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace freegs::semantics {
namespace {

// The mean colour of CLIP's training images, which its networks see as zero.
constexpr std::array<uint8_t, 3> kGrey = {123, 117, 104};
constexpr int kMinSide = 8;

struct PixelBox {
  int left;
  int top;
  int right;   // Past the last pixel.
  int bottom;  // Past the last pixel.

  bool empty() const { return right <= left; }
  void Include(int x, int y) {
    left = std::min(left, x);
    top = std::min(top, y);
    right = std::max(right, x + 1);
    bottom = std::max(bottom, y + 1);
  }
};

PixelBox BoxOf(const Image<int32_t>& labels, int32_t label) {
  PixelBox box{labels.width(), labels.height(), 0, 0};
  for (int y = 0; y < labels.height(); ++y) {
    for (int x = 0; x < labels.width(); ++x) {
      if (labels(x, y) == label) box.Include(x, y);
    }
  }
  return box;
}

}  // namespace

std::optional<InstanceCrop> CropInstance(const ImageU8& photo,
                                         const Image<int32_t>& labels,
                                         int32_t label,
                                         double margin) {
  const PixelBox box = BoxOf(labels, label);
  if (box.empty()) return std::nullopt;
  const int longer = std::max(box.right - box.left, box.bottom - box.top);
  const int side = std::max(
      kMinSide, static_cast<int>(std::lround(longer * (1 + 2 * margin))));
  const int left = (box.left + box.right - side) / 2;
  const int top = (box.top + box.bottom - side) / 2;
  InstanceCrop crop{ImageU8(side, side, 3), ImageU8(side, side, 3)};
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      const int from_x = left + x;
      const int from_y = top + y;
      const bool inside = from_x >= 0 && from_x < photo.width() &&
                          from_y >= 0 && from_y < photo.height();
      const bool own = inside && labels(from_x, from_y) == label;
      for (int c = 0; c < 3; ++c) {
        crop.in_place(x, y, c) = inside ? photo(from_x, from_y, c) : kGrey[c];
        crop.alone(x, y, c) = own ? photo(from_x, from_y, c) : kGrey[c];
      }
    }
  }
  return crop;
}

std::vector<LabelSight> SightsOf(size_t view,
                                 const Image<int32_t>& labels,
                                 int num_labels) {
  std::vector<LabelSight> sights(num_labels, {.view = view});
  for (int y = 0; y < labels.height(); ++y) {
    for (int x = 0; x < labels.width(); ++x) {
      const int32_t label = labels(x, y);
      if (label < 0 || label >= num_labels) continue;
      ++sights[label].pixels;
      sights[label].cut |= x == 0 || y == 0 || x + 1 == labels.width() ||
                           y + 1 == labels.height();
    }
  }
  return sights;
}

std::vector<LabelSight> BestSights(std::vector<LabelSight> sights,
                                   size_t count) {
  const auto worth = [](const LabelSight& sight) {
    return sight.cut ? sight.pixels : 2 * sight.pixels;
  };
  std::stable_sort(sights.begin(),
                   sights.end(),
                   [&](const LabelSight& a, const LabelSight& b) {
                     return worth(a) > worth(b);
                   });
  if (sights.size() > count) sights.resize(count);
  return sights;
}

}  // namespace freegs::semantics
