// SPDX-License-Identifier: BSD-3-Clause
// Colour between interleaved images and the planar memory of a tile (SIMD).

#ifndef FREEGS_SPLAT_RENDER_TILE_IMAGES_H_
#define FREEGS_SPLAT_RENDER_TILE_IMAGES_H_

#include "core/image.h"
#include "splat/render/tile_layout.h"

namespace freegs::splat {

// Writes colour + transmittance * background of the tile's pixels into *image
// (H x W x 3).
void StoreColorTile(const TileTask& task,
                    const TilePixels& pixels,
                    const float background[3],
                    ImageF* image);

// The tile's pixels of image (H x W x 3; null counts as zeros) as planes, 0
// outside the image.
void LoadColorTile(const TileTask& task,
                   const ImageF* image,
                   float planes[3][kTilePixels]);

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_RENDER_TILE_IMAGES_H_
