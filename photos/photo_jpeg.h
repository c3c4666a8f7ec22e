// SPDX-License-Identifier: BSD-3-Clause
// JPEG decoding that tells a damaged picture from a whole one.

#ifndef FREEGS_PHOTOS_PHOTO_JPEG_H_
#define FREEGS_PHOTOS_PHOTO_JPEG_H_

#include <string_view>

#include "core/image.h"
#include "core/status.h"

namespace freegs::photos {

// Pixels as stored, 3 channels (grey is repeated, CMYK converted without a
// profile). Uses libjpeg itself because OpenCV hides its warnings: data that
// end early or make no sense are filled with grey without an error. kBadInput
// for such data, as a phrase without the file's name. Never prints.
StatusOr<ImageU8> DecodeJpeg(std::string_view bytes);

}  // namespace freegs::photos

#endif  // FREEGS_PHOTOS_PHOTO_JPEG_H_
