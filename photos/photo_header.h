// SPDX-License-Identifier: BSD-3-Clause
// What an image file says about itself, read without decoding it: a header that
// lies is found before memory is spent on it, and a file that ends early before
// a decoder fills the rest with grey.

#ifndef FREEGS_PHOTOS_PHOTO_HEADER_H_
#define FREEGS_PHOTOS_PHOTO_HEADER_H_

#include <cstddef>
#include <cstdint>
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

  // True if there may be transparent pixels.
  bool has_alpha = false;
  // TIFF only: colours are already multiplied by alpha.
  bool premultiplied = false;

  // Grey or RGB samples of 8 bits that any program reads the same way; false
  // for palettes, CMYK and the like.
  bool plain = true;

  // The file ends before the image data does.
  bool truncated = false;

  // An upper bound of the pixels that this much compressed data can hold; a
  // header that claims more lies.
  double max_pixels = 0;

  ExifTags exif;
};

// The format by the first bytes; kBadInput naming what the file seems to be
// instead, with advice.
StatusOr<PhotoFormat> SniffFormat(std::string_view bytes);

// Reads the header and walks the structure of a whole file. kBadInput when the
// header itself is missing, damaged or of a kind that cannot be decoded; the
// message is a phrase without the file's name.
StatusOr<PhotoHeader> ParsePhotoHeader(std::string_view bytes);

// The formats, one by one; bytes begin with their signature.
StatusOr<PhotoHeader> ParseJpegHeader(std::string_view bytes);
StatusOr<PhotoHeader> ParsePngHeader(std::string_view bytes);
StatusOr<PhotoHeader> ParseTiffHeader(std::string_view bytes);

// The same PNG with only the chunks its pixels need: no profiles or texts for
// the decoder to stumble over. The header must have been parsed without error.
std::string EssentialPng(std::string_view bytes);

// The same TIFF declared upright and its alpha already applied (both have the
// value 1), so that a decoder neither turns it nor multiplies colours: whether
// they do depends on their version and on the sample type.
std::string NeutralTiff(std::string_view bytes);

}  // namespace freegs::photos

#endif  // FREEGS_PHOTOS_PHOTO_HEADER_H_
