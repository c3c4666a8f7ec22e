// SPDX-License-Identifier: BSD-3-Clause

#include "photos/photo_exif.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/pinhole.h"
#include "core/status.h"
#include "photos/photo_tiff.h"

namespace freegs::photos {
namespace {

// IFD 0.
constexpr uint16_t kMake = 0x010f;
constexpr uint16_t kModel = 0x0110;
constexpr uint16_t kOrientation = 0x0112;
constexpr uint16_t kExifDirectory = 0x8769;
// The EXIF directory.
constexpr uint16_t kFocalLength = 0x920a;
constexpr uint16_t kPixelXDimension = 0xa002;
constexpr uint16_t kPixelYDimension = 0xa003;
constexpr uint16_t kFocalPlaneXResolution = 0xa20e;
constexpr uint16_t kFocalPlaneResolutionUnit = 0xa210;
constexpr uint16_t kDigitalZoomRatio = 0xa404;
constexpr uint16_t kFocalLengthIn35mmFilm = 0xa405;

using Tags = std::vector<TiffEntry>;

std::optional<double> PositiveReal(const TiffReader& reader,
                                   const Tags& tags,
                                   uint16_t tag) {
  const TiffEntry* entry = FindTag(tags, tag);
  if (entry == nullptr) return std::nullopt;
  const std::optional<double> value = reader.Real(*entry);
  return value && *value > 0 ? value : std::nullopt;
}

std::string Text(const TiffReader& reader, const Tags& tags, uint16_t tag) {
  const TiffEntry* entry = FindTag(tags, tag);
  return entry == nullptr ? "" : reader.Text(*entry);
}

}  // namespace

ExifTags ParseExif(std::string_view block) {
  ExifTags exif;
  const StatusOr<TiffReader> reader = TiffReader::Open(block);
  if (!reader.ok()) return exif;
  const StatusOr<Tags> tags = reader->Directory(reader->first_directory());
  if (!tags.ok()) return exif;

  exif.make = Text(*reader, *tags, kMake);
  exif.model = Text(*reader, *tags, kModel);
  if (const TiffEntry* entry = FindTag(*tags, kOrientation)) {
    const uint32_t orientation = reader->Unsigned(*entry).value_or(1);
    if (orientation >= 1 && orientation <= 8) {
      exif.orientation = static_cast<int>(orientation);
    }
  }

  const TiffEntry* pointer = FindTag(*tags, kExifDirectory);
  if (pointer == nullptr) return exif;
  const StatusOr<Tags> details =
      reader->Directory(reader->Unsigned(*pointer).value_or(0));
  if (!details.ok()) return exif;
  exif.focal_length_mm = PositiveReal(*reader, *details, kFocalLength);
  exif.focal_length_35mm =
      PositiveReal(*reader, *details, kFocalLengthIn35mmFilm);
  exif.digital_zoom =
      PositiveReal(*reader, *details, kDigitalZoomRatio).value_or(1);
  const std::optional<double> x =
      PositiveReal(*reader, *details, kPixelXDimension);
  const std::optional<double> y =
      PositiveReal(*reader, *details, kPixelYDimension);
  if (x && y) exif.focal_plane_longest_side = std::max(*x, *y);
  const std::optional<double> resolution =
      PositiveReal(*reader, *details, kFocalPlaneXResolution);
  if (resolution) {
    const TiffEntry* unit = FindTag(*details, kFocalPlaneResolutionUnit);
    // 2 inch (the default), 3 centimetre.
    const uint32_t code =
        unit == nullptr ? 2 : reader->Unsigned(*unit).value_or(2);
    if (code == 2) exif.focal_plane_pixels_per_mm = *resolution / 25.4;
    if (code == 3) exif.focal_plane_pixels_per_mm = *resolution / 10;
  }
  return exif;
}

std::optional<double> FocalLengthPixels(const ExifTags& exif,
                                        int width,
                                        int height) {
  std::optional<double> focal;
  if (exif.focal_length_35mm) {
    focal = *exif.focal_length_35mm * std::hypot(width, height) /
            std::hypot(36.0, 24.0);
  } else if (exif.focal_length_mm && exif.focal_plane_pixels_per_mm &&
             exif.focal_plane_longest_side) {
    // The tags describe the image as the camera wrote it; a resized copy keeps
    // them, so scale by the longest side.
    focal = *exif.focal_length_mm * *exif.focal_plane_pixels_per_mm *
            std::max(width, height) / *exif.focal_plane_longest_side;
  }
  if (!focal) return std::nullopt;
  // A length that no photograph has comes from a wrong tag.
  const double ratio = *focal / std::max(width, height);
  if (!(ratio >= kMinFocalRatio && ratio <= kMaxFocalRatio)) {
    return std::nullopt;
  }
  return focal;
}

}  // namespace freegs::photos
