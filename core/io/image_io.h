// SPDX-License-Identifier: BSD-3-Clause
// Image files, through OpenCV.

#ifndef FREEGS_CORE_IO_IMAGE_IO_H_
#define FREEGS_CORE_IO_IMAGE_IO_H_

#include <filesystem>

#include "core/image.h"
#include "core/status.h"

namespace freegs {

// Reads an 8-bit RGB image (grey is repeated, alpha dropped, 16 bits reduced).
// EXIF orientation is ignored: pixels as stored, which is what camera
// intrinsics refer to after ingest.
StatusOr<ImageU8> ReadRgb(const std::filesystem::path& path);

// Reads a single-channel label image without any scaling, 8 or 16 bits.
StatusOr<ImageU16> ReadLabels(const std::filesystem::path& path);

// Writes PNG, JPEG (quality 95) or TIFF by suffix, atomically; 1, 3 or 4
// channels.
Status WriteImage(const std::filesystem::path& path, const ImageU8& image);

// Writes a 16-bit grey PNG, atomically.
Status WriteLabels(const std::filesystem::path& path, const ImageU16& labels);

// [0, 1] floats of 8-bit values, and back with rounding and clamping.
ImageF ToFloat(const ImageU8& image);
ImageU8 ToU8(const ImageF& image);

// Area-averaging when smaller, bilinear when larger.
ImageU8 Resize(const ImageU8& image, int width, int height);

}  // namespace freegs

#endif  // FREEGS_CORE_IO_IMAGE_IO_H_
