// SPDX-License-Identifier: BSD-3-Clause
// Keeps pixels that a mask says to ignore out of what is computed of an image.
// A mask has one channel, the size of the image, 0 for ignore.

#ifndef FREEGS_SPLAT_IMAGES_IGNORED_PIXELS_H_
#define FREEGS_SPLAT_IMAGES_IGNORED_PIXELS_H_

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "core/image.h"

namespace freegs::splat {

// Replaces the ignored pixels of *image by those of `from`, of the same shape.
template <typename T>
void CopyIgnored(const ImageU8& mask, const Image<T>& from, Image<T>* image) {
  const auto channels = static_cast<size_t>(image->channels());
  for (size_t i = 0; i < mask.num_pixels(); ++i) {
    if (mask.data()[i] != 0) continue;
    std::copy_n(
        from.data() + i * channels, channels, image->data() + i * channels);
  }
}

// Sets all channels of the ignored pixels of *image to `value`.
template <typename T>
void FillIgnored(const ImageU8& mask, T value, Image<T>* image) {
  const auto channels = static_cast<size_t>(image->channels());
  for (size_t i = 0; i < mask.num_pixels(); ++i) {
    if (mask.data()[i] != 0) continue;
    std::fill_n(image->data() + i * channels, channels, value);
  }
}

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_IMAGES_IGNORED_PIXELS_H_
