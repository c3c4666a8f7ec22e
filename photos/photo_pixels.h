// SPDX-License-Identifier: BSD-3-Clause
// Operations on decoded photos.

#ifndef FREEGS_PHOTOS_PHOTO_PIXELS_H_
#define FREEGS_PHOTOS_PHOTO_PIXELS_H_

#include <cstdint>
#include <string>

#include "core/image.h"

namespace freegs::photos {

// Turns and mirrors a picture so that it is upright. `orientation` is EXIF's, 1
// to 8.
// Source: CIPA DC-008 (Exif 2.32), tag 274.
ImageU8 Upright(const ImageU8& image, int orientation);

// Measures how sharp an RGB photo is: the variance of the Laplacian
// (4-neighbour kernel) of its grey version (0..255). A photo whose longest side
// exceeds 512 pixels is first reduced to that by area averaging. So the values
// of photos of one scene can be compared whatever their sizes, noise of single
// pixels does not count, and what counts is structure that motion or focus can
// take away. Source: Pech-Pacheco et al., "Diatom autofocusing in brightfield
// microscopy", ICPR 2000.
double Sharpness(const ImageU8& rgb);

// Hashes size, number of channels and pixels.
std::string ContentHash(const ImageU8& image);

}  // namespace freegs::photos

#endif  // FREEGS_PHOTOS_PHOTO_PIXELS_H_
