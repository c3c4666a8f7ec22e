// SPDX-License-Identifier: BSD-3-Clause
// The few EXIF tags that matter to reconstruction.

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

  // Image pixels per millimetre on the sensor, and the longest side in pixels
  // of the image that they refer to.
  std::optional<double> focal_plane_pixels_per_mm;
  std::optional<double> focal_plane_longest_side;
};

// Tags of an EXIF block (a TIFF structure, without the "Exif\0\0" before it) or
// of a whole TIFF file. Missing or damaged tags stay at their defaults: EXIF is
// a hint, never a reason to refuse a photo.
// Source: CIPA DC-008 (Exif 2.32), tables 4 and 7.
ExifTags ParseExif(std::string_view block);

// Focal length in pixels of a photo of width x height pixels (either way up)
// that the tags imply, or nothing. The 35 mm equivalent relates the image
// diagonal to that of a 36 x 24 mm film frame (CIPA DCG-001).
std::optional<double> FocalLengthPixels(const ExifTags& exif,
                                        int width,
                                        int height);

}  // namespace freegs::photos

#endif  // FREEGS_PHOTOS_PHOTO_EXIF_H_
