// SPDX-License-Identifier: BSD-3-Clause
// The EXIF tags that reconstruction uses.

#ifndef FREEGS_PHOTOS_PHOTO_EXIF_H_
#define FREEGS_PHOTOS_PHOTO_EXIF_H_

#include <optional>
#include <string>
#include <string_view>

namespace freegs::photos {

struct ExifTags {
  int orientation = 1;  // 1..8 as EXIF defines it; 1 is upright.
  std::string make;
  std::string model;
  std::optional<double> focal_length_mm;
  std::optional<double> focal_length_35mm;  // 35 mm equivalent.

  // By how much the camera has enlarged a part of the image. Whether the 35 mm
  // equivalent includes it differs from camera to camera.
  double digital_zoom = 1;

  // Pixels of the image per millimetre on the sensor, and the longest side, in
  // pixels, of the image that this refers to.
  std::optional<double> focal_plane_pixels_per_mm;
  std::optional<double> focal_plane_longest_side;
};

// Reads the tags of an EXIF block, which is a TIFF structure without the
// "Exif\0\0" before it, or of a whole TIFF file. Missing and damaged tags keep
// their defaults, because EXIF is a hint and no reason to refuse a photo.
// Source: CIPA DC-008 (Exif 2.32), tables 4 and 7.
ExifTags ParseExif(std::string_view block);

// Returns the focal length in pixels that the tags imply for a photo of
// width x height pixels, which may be turned; nothing when they do not tell.
// The 35 mm equivalent relates the diagonal of the image to that of a film
// frame of 36 x 24 mm (CIPA DCG-001).
std::optional<double> FocalLengthPixels(const ExifTags& exif,
                                        int width,
                                        int height);

}  // namespace freegs::photos

#endif  // FREEGS_PHOTOS_PHOTO_EXIF_H_
