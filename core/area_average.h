// SPDX-License-Identifier: BSD-3-Clause

#ifndef FREEGS_CORE_AREA_AVERAGE_H_
#define FREEGS_CORE_AREA_AVERAGE_H_

#include "core/image.h"

namespace freegs {

// The image in another size, of at least one pixel: each pixel is the mean over
// the part of `image` that it covers, rounded to the nearest value. It is
// computed with whole numbers, so that it is the same on all processors, which
// that of OpenCV is not. Sides are at most 65535 pixels.
ImageU8 AreaAverage(const ImageU8& image, int width, int height);

}  // namespace freegs

#endif  // FREEGS_CORE_AREA_AVERAGE_H_
