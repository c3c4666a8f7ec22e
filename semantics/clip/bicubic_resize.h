// SPDX-License-Identifier: BSD-3-Clause
// The bicubic resampling that CLIP was trained with, to the bit. The bicubic
// resize of OpenCV has another kernel, and it does not widen the kernel when an
// image shrinks.

#ifndef FREEGS_SEMANTICS_CLIP_BICUBIC_RESIZE_H_
#define FREEGS_SEMANTICS_CLIP_BICUBIC_RESIZE_H_

#include "core/image.h"

namespace freegs::semantics {

// A part of a resized image, in pixels of the resized image.
struct ResizeWindow {
  int x = 0;
  int y = 0;
  int width = 0;
  int height = 0;
};

// Returns the window of `image` resized to width x height. The window must lie
// within width x height; what lies outside of it costs no time. The image must
// not be empty and may have any number of channels.
//
// As in the Python Imaging Library, the kernel is that of Keys with a = -0.5,
// as wide as a pixel of the smaller image, clipped at the borders and
// normalised. Rows are resized before columns; coefficients have 22 bits, and
// values are rounded to 8 bits after each of the two steps.
ImageU8 ResizeBicubic(const ImageU8& image,
                      int width,
                      int height,
                      const ResizeWindow& window);

// Returns the whole resized image.
ImageU8 ResizeBicubic(const ImageU8& image, int width, int height);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_CLIP_BICUBIC_RESIZE_H_
