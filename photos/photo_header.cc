// SPDX-License-Identifier: BSD-3-Clause

#include "photos/photo_header.h"

namespace freegs::photos {
namespace {

using namespace std::string_view_literals;

// First bytes of formats that people have photos in but we cannot read.
struct Signature {
  size_t offset;
  std::string_view bytes;
  std::string_view name;
};
constexpr Signature kOtherFormats[] = {
    {4, "ftypheic"sv, "HEIC"},
    {4, "ftypheix"sv, "HEIC"},
    {4, "ftypmif1"sv, "HEIF"},
    {4, "ftypavif"sv, "AVIF"},
    {4, "ftypcrx "sv, "Canon raw"},
    {4, "ftyp"sv, "video"},
    {0, "RIFF"sv, "WebP or video"},
    {0, "GIF8"sv, "GIF"},
    {0, "BM"sv, "BMP"},
    {0, "\x76\x2f\x31\x01"sv, "OpenEXR"},
    {0, "\xff\x0a"sv, "JPEG XL"},
    {0, "FUJIFILMCCD-RAW"sv, "Fujifilm raw"},
    {0, "II\x2a\0\x10\0\0\0CR"sv, "Canon raw"},  // Looks like a TIFF.
};

bool HasAt(std::string_view bytes, size_t offset, std::string_view part) {
  return bytes.size() >= offset && bytes.substr(offset, part.size()) == part;
}

}  // namespace

std::string_view FormatName(PhotoFormat format) {
  switch (format) {
    case PhotoFormat::kJpeg:
      return "JPEG";
    case PhotoFormat::kPng:
      return "PNG";
    case PhotoFormat::kTiff:
      return "TIFF";
  }
  return "";
}

StatusOr<PhotoFormat> SniffFormat(std::string_view bytes) {
  if (bytes.empty()) {
    return BadInputError("empty file (0 bytes); copy it again or remove it");
  }
  if (HasAt(bytes, 0, "\xff\xd8\xff"sv)) return PhotoFormat::kJpeg;
  if (HasAt(bytes, 0, "\x89PNG\r\n\x1a\n"sv)) return PhotoFormat::kPng;
  for (const Signature& other : kOtherFormats) {
    if (HasAt(bytes, other.offset, other.bytes)) {
      return BadInputError("a " + std::string(other.name) +
                           " file, which cannot be read; convert it to JPEG, "
                           "PNG or TIFF");
    }
  }
  if (HasAt(bytes, 0, "II\x2a\0"sv) || HasAt(bytes, 0, "MM\0\x2a"sv) ||
      HasAt(bytes, 0, "II\x2b\0"sv) || HasAt(bytes, 0, "MM\0\x2b"sv)) {
    return PhotoFormat::kTiff;
  }
  return BadInputError(
      "not an image, whatever its name says; JPEG, PNG and TIFF can be read");
}

StatusOr<PhotoHeader> ParsePhotoHeader(std::string_view bytes) {
  FREEGS_ASSIGN_OR_RETURN(const PhotoFormat format, SniffFormat(bytes));
  switch (format) {
    case PhotoFormat::kJpeg:
      return ParseJpegHeader(bytes);
    case PhotoFormat::kPng:
      return ParsePngHeader(bytes);
    case PhotoFormat::kTiff:
      return ParseTiffHeader(bytes);
  }
  return InternalError("unknown format");
}

}  // namespace freegs::photos
