// SPDX-License-Identifier: BSD-3-Clause
// The resampling CLIP was trained with, to the bit: OpenCV's bicubic resize has
// another kernel and does not widen it when an image shrinks.

#ifndef FREEGS_SEMANTICS_CLIP_BICUBIC_RESIZE_H_
#define FREEGS_SEMANTICS_CLIP_BICUBIC_RESIZE_H_

#include "core/image.h"

namespace freegs::semantics {

// The part of a resized image that is wanted, in pixels of the resized image.
struct ResizeWindow {
  int x = 0;
  int y = 0;
  int width = 0;
  int height = 0;
};

// The window of `image` resized to width x height: Keys's bicubic kernel with
// a = -0.5, as wide as a pixel of the smaller image, clipped at the borders and
// normalised; horizontal before vertical, rounded to 8 bits after each, with
// coefficients of 22 bits, as the Python Imaging Library does. Costs nothing
// for what lies outside the window, which must lie within width x height. Any
// number of channels; the image must not be empty.
ImageU8 ResizeBicubic(const ImageU8& image,
                      int width,
                      int height,
                      const ResizeWindow& window);

// The whole of it.
ImageU8 ResizeBicubic(const ImageU8& image, int width, int height);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_CLIP_BICUBIC_RESIZE_H_
