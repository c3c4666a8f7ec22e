// SPDX-License-Identifier: BSD-3-Clause
// Operations on decoded photos.

#ifndef FREEGS_PHOTOS_PHOTO_PIXELS_H_
#define FREEGS_PHOTOS_PHOTO_PIXELS_H_

#include <cstdint>
#include <string>

#include "core/image.h"

namespace freegs::photos {

// The picture turned and mirrored upright, for an EXIF orientation of 1..8.
// Source: CIPA DC-008 (Exif 2.32), tag 274.
ImageU8 Upright(const ImageU8& image, int orientation);

// How sharp an RGB photo is: the variance of the Laplacian (4-neighbour kernel)
// of its grey version (0..255). Larger photos are first reduced to a longest
// side of 512 pixels by area averaging: the value is then about structure that
// the scene has and motion or focus took away, it compares between photos of
// one scene whatever their size, and noise of single pixels does not count.
// Source: Pech-Pacheco et al., "Diatom autofocusing in brightfield microscopy",
// ICPR 2000.
double Sharpness(const ImageU8& rgb);

// Hash of size, channels and pixels.
std::string ContentHash(const ImageU8& image);

}  // namespace freegs::photos

#endif  // FREEGS_PHOTOS_PHOTO_PIXELS_H_
