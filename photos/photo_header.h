// SPDX-License-Identifier: BSD-3-Clause
// Reads what an image file says about itself without decoding it. So a header
// that claims a false size is found before memory is taken for the pixels, and
// a file that ends early is found before a decoder fills the rest with grey.

#ifndef FREEGS_PHOTOS_PHOTO_HEADER_H_
#define FREEGS_PHOTOS_PHOTO_HEADER_H_

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "core/status.h"
#include "photos/photo_exif.h"

namespace freegs::photos {

enum class PhotoFormat { kJpeg, kPng, kTiff };

// "JPEG", "PNG", "TIFF".
std::string_view FormatName(PhotoFormat format);

struct PhotoHeader {
  PhotoFormat format = PhotoFormat::kJpeg;
  int64_t width = 0;   // Pixels as stored, before orientation.
  int64_t height = 0;  // Pixels.
  int bits = 8;        // Per sample.
  int samples = 3;     // Per pixel: colours and alpha.

  // Whether there may be transparent pixels.
  bool has_alpha = false;
  // The decoded sample of a grey PNG that is transparent, in 0..255 or
  // 0..65535. It has no meaning where there are colours.
  std::optional<int> transparent_grey;

  // Whether colours are already multiplied by alpha. Only TIFF files do so.
  bool premultiplied = false;

  // Whether the samples are grey or RGB of 8 bits, which every program reads in
  // the same way. False for palettes, CMYK and the like, for a PNG with a gamma
  // that some programs apply, and for one that decoders read only without some
  // of its chunks (EssentialPng).
  bool plain = true;

  // Whether the file ends before the image data does.
  bool truncated = false;

  // An upper bound of the number of pixels that the file's compressed data can
  // hold. A header that claims more is false.
  double max_pixels = 0;

  ExifTags exif;
};

// Returns the format that the first bytes tell. The message of kBadInput names
// what the file seems to be instead, with advice.
StatusOr<PhotoFormat> SniffFormat(std::string_view bytes);

// Reads the header of a file, all of whose bytes are given, and walks through
// its structure. Returns kBadInput when the header is missing, damaged or of a
// kind that cannot be decoded; the message is a phrase without the file's name.
StatusOr<PhotoHeader> ParsePhotoHeader(std::string_view bytes);

// Does the same for one format. `bytes` begins with the signature of the
// format.
StatusOr<PhotoHeader> ParseJpegHeader(std::string_view bytes);
StatusOr<PhotoHeader> ParsePngHeader(std::string_view bytes);
StatusOr<PhotoHeader> ParseTiffHeader(std::string_view bytes);

// Returns the PNG with only those chunks that its pixels need, so that the
// decoder does not fail on profiles or texts. The header must have been parsed
// without error.
std::string EssentialPng(std::string_view bytes);

// Returns the TIFF with its orientation set to upright and its alpha marked as
// already applied; both tags get the value 1. So a decoder neither turns the
// picture nor multiplies colours by alpha. Otherwise that would depend on the
// version of the decoder and on the type of the samples.
std::string NeutralTiff(std::string_view bytes);

}  // namespace freegs::photos

#endif  // FREEGS_PHOTOS_PHOTO_HEADER_H_
