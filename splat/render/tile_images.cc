// SPDX-License-Identifier: BSD-3-Clause

#include "splat/render/tile_images.h"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "splat/render/tile_images.cc"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace freegs::splat::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// A row of a block.
using Tag = hn::CappedTag<float, kBlockSize>;

void StoreColor(const TileTask& task,
                const TilePixels& pixels,
                const float* background,
                ImageF* image) {
  const Tag d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto plane = [&](int channel, int pixel) HWY_ATTR {
    return hn::MulAdd(hn::Load(d, pixels.transmittance + pixel),
                      hn::Set(d, background[channel]),
                      hn::Load(d, pixels.color[channel] + pixel));
  };
  alignas(64) float rest[3 * kBlockSize];
  for (int y = 0; y < task.height; ++y) {
    float* row = image->row(task.y0 + y) + 3 * task.x0;
    for (int x = 0; x < task.width; x += lanes) {
      const int pixel = TilePixel(x, y);
      const bool whole = x + lanes <= task.width;
      hn::StoreInterleaved3(plane(0, pixel),
                            plane(1, pixel),
                            plane(2, pixel),
                            d,
                            whole ? row + 3 * x : rest);
      if (!whole) std::copy_n(rest, 3 * (task.width - x), row + 3 * x);
    }
  }
}

void LoadColor(const TileTask& task,
               const ImageF& image,
               float (*planes)[kTilePixels]) {
  const Tag d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  alignas(64) float rest[3 * kBlockSize];
  for (int y = 0; y < task.height; ++y) {
    const float* row = image.row(task.y0 + y) + 3 * task.x0;
    for (int x = 0; x < task.width; x += lanes) {
      const float* at = row + 3 * x;
      if (x + lanes > task.width) {
        std::fill_n(rest, 3 * kBlockSize, 0.0f);
        std::copy_n(at, 3 * (task.width - x), rest);
        at = rest;
      }
      hn::Vec<Tag> red, green, blue;
      hn::LoadInterleaved3(d, at, red, green, blue);
      const int pixel = TilePixel(x, y);
      hn::Store(red, d, planes[0] + pixel);
      hn::Store(green, d, planes[1] + pixel);
      hn::Store(blue, d, planes[2] + pixel);
    }
  }
}

}  // namespace freegs::splat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace freegs::splat {

HWY_EXPORT(StoreColor);
HWY_EXPORT(LoadColor);

void StoreColorTile(const TileTask& task,
                    const TilePixels& pixels,
                    const float background[3],
                    ImageF* image) {
  HWY_DYNAMIC_DISPATCH(StoreColor)(task, pixels, background, image);
}

void LoadColorTile(const TileTask& task,
                   const ImageF* image,
                   float planes[3][kTilePixels]) {
  const bool whole = task.width == kTileSize && task.height == kTileSize;
  if (image == nullptr || !whole) std::fill_n(planes[0], 3 * kTilePixels, 0.0f);
  if (image != nullptr) HWY_DYNAMIC_DISPATCH(LoadColor)(task, *image, planes);
}

}  // namespace freegs::splat
#endif  // HWY_ONCE
