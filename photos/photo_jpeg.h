// SPDX-License-Identifier: BSD-3-Clause
// Decodes JPEG files and tells damaged pictures from whole ones.

#ifndef FREEGS_PHOTOS_PHOTO_JPEG_H_
#define FREEGS_PHOTOS_PHOTO_JPEG_H_

#include <string_view>

#include "core/image.h"
#include "core/status.h"
#include "photos/photo_header.h"

namespace freegs::photos {

// Returns the pixels as they are stored, in 3 channels. Grey is repeated, and
// CMYK is converted without a profile. Returns kBadInput for data that end
// early or make no sense; the message is a phrase without the file's name. This
// uses libjpeg directly, because OpenCV hides libjpeg's warnings and fills such
// pictures with grey without an error.
//
// `header` is what ParseJpegHeader says of the bytes. A file whose size libjpeg
// reads otherwise is refused before memory is taken for its pixels.
StatusOr<ImageU8> DecodeJpeg(std::string_view bytes, const PhotoHeader& header);

}  // namespace freegs::photos

#endif  // FREEGS_PHOTOS_PHOTO_JPEG_H_
