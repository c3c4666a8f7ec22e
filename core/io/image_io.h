// SPDX-License-Identifier: BSD-3-Clause
// Reads and writes image files with OpenCV.

#ifndef FREEGS_CORE_IO_IMAGE_IO_H_
#define FREEGS_CORE_IO_IMAGE_IO_H_

#include <filesystem>

#include "core/image.h"
#include "core/status.h"

namespace freegs {

// Reads a PNG, JPEG or TIFF image as 8-bit RGB. Grey is repeated, alpha is
// dropped and 16-bit samples are reduced. EXIF orientation is ignored: camera
// intrinsics refer to pixels as they are stored. Returns kBadInput for what
// cannot be read or is no such image.
StatusOr<ImageU8> ReadRgb(const std::filesystem::path& path);

// Reads the values of a one-channel PNG or JPEG image of 8 or 16 bits, or of a
// grey PNG of fewer bits, as they are stored. Returns kBadInput for anything
// else: of some TIFF images, OpenCV stretches or inverts the values.
StatusOr<ImageU16> ReadLabels(const std::filesystem::path& path);

// Writes an image of 1, 3 or 4 channels, atomically. The suffix of the path, in
// any case, decides: .png, .jpg, .jpeg or .jpe (quality 95), .tif or .tiff.
// Returns kInternal for other suffixes and other numbers of channels, and where
// the file cannot be written.
Status WriteImage(const std::filesystem::path& path, const ImageU8& image);

// Whether the suffix of the path is one that WriteImage knows.
bool CanWriteImage(const std::filesystem::path& path);

// Writes a 16-bit grey PNG, atomically, whatever the suffix of the path is:
// JPEG would change the values. Returns kInternal where the file cannot be
// written.
Status WriteLabels(const std::filesystem::path& path, const ImageU16& labels);

// Converts 8-bit values to floats in [0, 1], and back with clamping and
// rounding.
ImageF ToFloat(const ImageU8& image);
ImageU8 ToU8(const ImageF& image);

// Resizes by area averaging to a smaller size, bilinearly to a larger one.
ImageU8 Resize(const ImageU8& image, int width, int height);

}  // namespace freegs

#endif  // FREEGS_CORE_IO_IMAGE_IO_H_
