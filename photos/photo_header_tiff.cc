// SPDX-License-Identifier: BSD-3-Clause
// TIFF Revision 6.0 (Adobe, 1992), sections 2 to 8 and 18.

#include <algorithm>
#include <limits>
#include <optional>
#include <vector>

#include "photos/photo_header.h"
#include "photos/photo_tiff.h"

namespace freegs::photos {
namespace {

constexpr uint16_t kNewSubfileType = 254;
constexpr uint16_t kImageWidth = 256;
constexpr uint16_t kImageLength = 257;
constexpr uint16_t kBitsPerSample = 258;
constexpr uint16_t kCompression = 259;
constexpr uint16_t kPhotometric = 262;
constexpr uint16_t kStripOffsets = 273;
constexpr uint16_t kOrientationTag = 274;
constexpr uint16_t kSamplesPerPixel = 277;
constexpr uint16_t kStripByteCounts = 279;
constexpr uint16_t kPlanarConfiguration = 284;
constexpr uint16_t kTileOffsets = 324;
constexpr uint16_t kTileByteCounts = 325;
constexpr uint16_t kExtraSamples = 338;
constexpr uint16_t kSampleFormat = 339;
constexpr uint16_t kDngVersion = 50706;

constexpr uint32_t kUncompressed = 1;
constexpr uint32_t kLzw = 5;
constexpr uint32_t kDeflate = 8;
constexpr uint32_t kOldDeflate = 32946;
constexpr uint32_t kPackBits = 32773;
constexpr uint32_t kUnsignedInteger = 1;
constexpr uint32_t kPlanar = 2;  // One plane for each colour.
constexpr uint32_t kNoAlpha = 0;
constexpr uint32_t kAssociatedAlpha = 1;
constexpr uint32_t kOtherAlpha = 2;
constexpr uint32_t kReducedImage = 1;    // One bit of kNewSubfileType.
constexpr uint32_t kNegativePixels = 0;  // Grey, of which 0 is white.
constexpr uint32_t kGreyPixels = 1;
constexpr uint32_t kRgbPixels = 2;
constexpr uint32_t kPalettePixels = 3;
constexpr uint32_t kMaskPixels = 4;
constexpr uint32_t kCmykPixels = 5;
constexpr uint32_t kYCbCrPixels = 6;
constexpr uint32_t kSensorPixels = 32803;

using Tags = std::vector<TiffEntry>;

uint32_t UnsignedTag(const TiffReader& reader,
                     const Tags& tags,
                     uint16_t tag,
                     uint32_t missing) {
  const TiffEntry* entry = FindTag(tags, tag);
  return entry == nullptr ? missing : reader.Unsigned(*entry).value_or(missing);
}

// Raw files of many cameras are TIFFs whose first picture is a preview, which
// must not be taken for the photo.
Status CheckTiffKind(const TiffReader& reader, const Tags& tags) {
  const uint32_t pixels = UnsignedTag(reader, tags, kPhotometric, kRgbPixels);
  if ((UnsignedTag(reader, tags, kNewSubfileType, 0) & kReducedImage) != 0 ||
      FindTag(tags, kDngVersion) != nullptr || pixels == kSensorPixels) {
    return BadInputError(
        "a camera raw file, which cannot be read; convert it to JPEG, PNG or "
        "TIFF");
  }
  if (pixels == kMaskPixels || pixels > kYCbCrPixels) {
    return BadInputError(
        "a TIFF of other colours than grey, RGB, CMYK or YCbCr, which cannot "
        "be read; convert it to RGB");
  }
  if (pixels == kCmykPixels &&
      UnsignedTag(reader, tags, kBitsPerSample, 1) == 16) {
    return BadInputError(
        "a CMYK TIFF of 16 bits, which cannot be read; convert it to RGB");
  }
  return Status();
}

std::string PixelsName(uint32_t pixels) {
  switch (pixels) {
    case kNegativePixels:
    case kGreyPixels:
      return "grey";
    case kRgbPixels:
      return "RGB";
    case kPalettePixels:
      return "palette";
    case kCmykPixels:
      return "CMYK";
    default:
      return "YCbCr";
  }
}

// Whether OpenCV decodes pixels of these samples. Of grey pixels it would drop
// alpha, and mix up tiles and more than 8 bits; of a palette of 1 bit it drops
// the colours; all else it refuses.
bool CanDecode(uint32_t pixels, int bits, int samples) {
  switch (pixels) {
    case kNegativePixels:
    case kGreyPixels:
      return samples == 1;
    case kRgbPixels:
      return bits >= 8 && (samples == 3 || samples == 4);
    case kPalettePixels:
      return bits == 8 && samples == 1;
    case kCmykPixels:
      return bits == 8 && samples == 4;
    default:
      return bits == 8 && samples == 3;
  }
}

// Refuses what OpenCV 4.6 cannot decode, or would decode to other pixels
// without a word.
Status CheckTiffSamples(const TiffReader& reader,
                        const Tags& tags,
                        int bits,
                        int samples) {
  const uint32_t sample_format =
      UnsignedTag(reader, tags, kSampleFormat, kUnsignedInteger);
  const bool known_depth =
      bits == 1 || (bits >= 8 && bits <= 16 && bits % 2 == 0);
  if (sample_format != kUnsignedInteger || !known_depth) {
    return BadInputError("a TIFF of floating-point, signed or " +
                         std::to_string(bits) +
                         "-bit samples; convert it to 8 or 16 bits");
  }
  const uint32_t pixels = UnsignedTag(reader, tags, kPhotometric, kRgbPixels);
  if (!CanDecode(pixels, bits, samples)) {
    return BadInputError("a TIFF of a kind that cannot be read (" +
                         PixelsName(pixels) +
                         ", bits per sample: " + std::to_string(bits) +
                         ", samples per pixel: " + std::to_string(samples) +
                         "); convert it to grey or RGB of 8 bits, or to PNG");
  }
  if (bits > 8 && samples > 1 &&
      UnsignedTag(reader, tags, kPlanarConfiguration, 1) == kPlanar) {
    return BadInputError("a TIFF of " + std::to_string(bits) +
                         " bits with a plane for each colour, which cannot be "
                         "read; convert it to 8 bits or to PNG");
  }
  if (bits > 8 && pixels == kNegativePixels) {
    return BadInputError("a grey TIFF of " + std::to_string(bits) +
                         " bits in which 0 is white, which cannot be read; "
                         "convert it to 8 bits or to PNG");
  }
  return Status();
}

// How many bytes one byte of the file becomes at most, where the compression
// has such a bound.
std::optional<double> MaxRatio(uint32_t compression) {
  switch (compression) {
    case kUncompressed:
      return 1;
    case kLzw:
      return 4096 * 8 / 12;  // A code of 12 bits stands for one table entry.
    case kDeflate:
    case kOldDeflate:
      return 1032;
    case kPackBits:
      return 64;  // Two bytes become 128.
    default:
      return std::nullopt;
  }
}

// Adds up the strips (or tiles); false if one of them lies outside the file.
bool AddStrips(const TiffReader& reader,
               const Tags& tags,
               uint16_t offsets_tag,
               uint16_t counts_tag,
               size_t file_size,
               double* total) {
  const TiffEntry* offsets = FindTag(tags, offsets_tag);
  const TiffEntry* counts = FindTag(tags, counts_tag);
  if (offsets == nullptr || counts == nullptr) return true;
  for (uint32_t i = 0; i < std::min(offsets->count, counts->count); ++i) {
    const uint64_t offset = reader.Unsigned(*offsets, i).value_or(0);
    const uint64_t count = reader.Unsigned(*counts, i).value_or(0);
    if (offset + count > file_size) return false;
    *total += static_cast<double>(count);
  }
  return true;
}

}  // namespace

StatusOr<PhotoHeader> ParseTiffHeader(std::string_view bytes) {
  FREEGS_ASSIGN_OR_RETURN(const TiffReader reader, TiffReader::Open(bytes));
  bool complete = true;
  const StatusOr<Tags> directory =
      reader.Directory(reader.first_directory(), &complete);
  if (!directory.ok()) {
    return BadInputError(directory.status().message() +
                         "; copy the file again");
  }
  const Tags& tags = *directory;
  FREEGS_RETURN_IF_ERROR(CheckTiffKind(reader, tags));

  PhotoHeader header;
  header.format = PhotoFormat::kTiff;
  header.width = UnsignedTag(reader, tags, kImageWidth, 0);
  header.height = UnsignedTag(reader, tags, kImageLength, 0);
  if (header.width == 0 || header.height == 0) {
    return BadInputError("the TIFF header gives no size; copy the file again");
  }
  header.bits = static_cast<int>(
      std::min(UnsignedTag(reader, tags, kBitsPerSample, 1), 255U));
  header.samples = static_cast<int>(
      std::min(UnsignedTag(reader, tags, kSamplesPerPixel, 1), 255U));
  header.plain = false;
  if (header.bits == 0 || header.samples == 0) {
    return BadInputError("damaged TIFF header; copy the file again");
  }
  if (complete) {  // Else tags may be missing, and the file is truncated.
    FREEGS_RETURN_IF_ERROR(
        CheckTiffSamples(reader, tags, header.bits, header.samples));
  }
  // Writers that forget to say what the fourth sample is mean alpha.
  const uint32_t fourth = UnsignedTag(reader, tags, kExtraSamples, kOtherAlpha);
  header.has_alpha =
      UnsignedTag(reader, tags, kPhotometric, kRgbPixels) == kRgbPixels &&
      header.samples == 4 && fourth != kNoAlpha;
  header.premultiplied = fourth == kAssociatedAlpha;
  header.exif = ParseExif(bytes);

  double data_bytes = 0;
  complete = complete &&
             AddStrips(reader,
                       tags,
                       kStripOffsets,
                       kStripByteCounts,
                       bytes.size(),
                       &data_bytes) &&
             AddStrips(reader,
                       tags,
                       kTileOffsets,
                       kTileByteCounts,
                       bytes.size(),
                       &data_bytes);
  header.truncated = !complete || (FindTag(tags, kStripOffsets) == nullptr &&
                                   FindTag(tags, kTileOffsets) == nullptr);
  header.max_pixels = std::numeric_limits<double>::infinity();
  const std::optional<double> ratio =
      MaxRatio(UnsignedTag(reader, tags, kCompression, kUncompressed));
  if (ratio && (FindTag(tags, kStripByteCounts) != nullptr ||
                FindTag(tags, kTileByteCounts) != nullptr)) {
    header.max_pixels =
        *ratio * data_bytes * 8 / (header.bits * header.samples);
  }
  return header;
}

std::string NeutralTiff(std::string_view bytes) {
  std::string neutral(bytes);
  const StatusOr<TiffReader> reader = TiffReader::Open(bytes);
  if (!reader.ok()) return neutral;
  const StatusOr<Tags> tags = reader->Directory(reader->first_directory());
  if (!tags.ok()) return neutral;
  for (const uint16_t tag : {kOrientationTag, kExtraSamples}) {
    const TiffEntry* entry = FindTag(*tags, tag);
    if (entry == nullptr || !reader->Unsigned(*entry)) continue;
    // A BYTE, SHORT or LONG: all bytes 0 but the least significant.
    const size_t size = entry->type == 1 ? 1 : entry->type == 3 ? 2 : 4;
    for (size_t i = 0; i < size; ++i) neutral[entry->offset + i] = 0;
    const size_t least = reader->little_endian() ? 0 : size - 1;
    neutral[entry->offset + least] = 1;
  }
  return neutral;
}

}  // namespace freegs::photos
