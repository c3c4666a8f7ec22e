// SPDX-License-Identifier: BSD-3-Clause
// Copies colours between images, which are interleaved, and the memory of a
// tile, which has one plane per channel.

#ifndef FREEGS_SPLAT_RENDER_TILE_IMAGES_H_
#define FREEGS_SPLAT_RENDER_TILE_IMAGES_H_

#include "core/image.h"
#include "splat/render/tile_layout.h"

namespace freegs::splat {

// Writes color + transmittance * background of the tile's pixels to *image
// (H x W x 3).
void StoreColorTile(const TileTask& task,
                    const TilePixels& pixels,
                    const float background[3],
                    ImageF* image);

// Copies the tile's pixels of `image` (H x W x 3; null stands for zeros) to
// planes, with 0 for pixels outside the image.
void LoadColorTile(const TileTask& task,
                   const ImageF* image,
                   float planes[3][kTilePixels]);

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_RENDER_TILE_IMAGES_H_
