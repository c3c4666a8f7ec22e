// SPDX-License-Identifier: BSD-3-Clause

#include "photos/photo_decode.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <system_error>
#include <utility>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "core/io/files.h"
#include "core/number_text.h"
#include "core/out_of_memory.h"
#include "photos/photo_jpeg.h"
#include "photos/photo_pixels.h"

namespace freegs::photos {
namespace {

// Above this, photos are decoded one at a time.
constexpr int64_t kLargePhotoPixels = 50'000'000;

std::string SizeText(const PhotoHeader& header) {
  return std::to_string(header.width) + " x " + std::to_string(header.height) +
         " pixels";
}

Status DamagedError(const PhotoHeader& header) {
  return BadInputError("damaged " + std::string(FormatName(header.format)) +
                       ": its pixels cannot be decoded; copy the file again");
}

// Pixels in the file's own depth and channels, by OpenCV.
StatusOr<cv::Mat> DecodeStored(std::string_view bytes,
                               const PhotoHeader& header) {
  const std::string clean = header.format == PhotoFormat::kTiff
                                ? NeutralTiff(bytes)
                                : EssentialPng(bytes);
  const cv::Mat buffer(1,
                       static_cast<int>(clean.size()),
                       CV_8UC1,
                       const_cast<char*>(clean.data()));
  cv::Mat stored;
  try {
    stored = cv::imdecode(buffer, cv::IMREAD_UNCHANGED);
  } catch (const cv::Exception& error) {
    if (IsOutOfMemory(error)) throw;
    return DamagedError(header);
  }
  if (stored.empty() || stored.cols != header.width ||
      stored.rows != header.height ||
      (stored.depth() != CV_8U && stored.depth() != CV_16U)) {
    return DamagedError(header);
  }
  return stored;
}

// Lays BGRA over a grey level in 0..1, in place; the result is BGR.
template <typename T>
cv::Mat Composite(const cv::Mat& bgra, bool premultiplied, double background) {
  constexpr uint64_t kFull = std::numeric_limits<T>::max();
  const uint64_t below = static_cast<uint64_t>(std::lround(background * kFull));
  cv::Mat bgr(bgra.rows, bgra.cols, CV_MAKETYPE(bgra.depth(), 3));
  for (int y = 0; y < bgra.rows; ++y) {
    const T* from = bgra.ptr<T>(y);
    T* to = bgr.ptr<T>(y);
    for (int x = 0; x < bgra.cols; ++x, from += 4, to += 3) {
      const uint64_t alpha = from[3];
      for (int c = 0; c < 3; ++c) {
        const uint64_t above = from[c] * (premultiplied ? kFull : alpha);
        const uint64_t sum = above + below * (kFull - alpha);
        to[c] = static_cast<T>(std::min(kFull, (sum + kFull / 2) / kFull));
      }
    }
  }
  return bgr;
}

// OpenCV's channel orders and depths to 8-bit RGB.
StatusOr<ImageU8> ToRgb(cv::Mat stored,
                        const PhotoHeader& header,
                        const PhotoDecodeOptions& options) {
  const double background = options.background == "white" ? 1 : 0;
  if (stored.channels() == 1 && header.transparent_grey) {
    // OpenCV makes alpha of transparent colours, but not of a transparent grey.
    const double full = stored.depth() == CV_8U ? 255 : 65535;
    stored.setTo(background * full, stored == *header.transparent_grey);
  }
  if (stored.channels() == 4 && !header.has_alpha) {
    // CMYK, or a fourth sample that has nothing to do with the picture.
    cv::cvtColor(stored, stored, cv::COLOR_BGRA2BGR);
  } else if (stored.channels() == 4) {
    stored =
        stored.depth() == CV_8U
            ? Composite<uint8_t>(stored, header.premultiplied, background)
            : Composite<uint16_t>(stored, header.premultiplied, background);
  }
  if (stored.channels() != 1 && stored.channels() != 3) {
    return DamagedError(header);
  }
  if (stored.depth() == CV_16U) {
    cv::Mat reduced;
    if (options.only_zero_is_black) {
      reduced = stored > 0;
    } else {
      stored.convertTo(reduced, CV_8U, 1.0 / 257);
    }
    stored = reduced;
  }
  ImageU8 rgb(stored.cols, stored.rows, 3);
  cv::Mat target(stored.rows, stored.cols, CV_8UC3, rgb.data());
  cv::cvtColor(stored,
               target,
               stored.channels() == 1 ? cv::COLOR_GRAY2RGB : cv::COLOR_BGR2RGB);
  return rgb;
}

}  // namespace

Status PhotoDecodeOptions::Check() const {
  if (!(max_megapixels > 0)) {
    return InvalidArgumentError("max_megapixels must be positive");
  }
  if (min_side < 1) return InvalidArgumentError("min_side must be at least 1");
  if (background != "white" && background != "black") {
    return InvalidArgumentError("background must be white or black");
  }
  return Status();
}

Status CheckHeader(const PhotoHeader& header,
                   const PhotoDecodeOptions& options) {
  const double pixels =
      static_cast<double>(header.width) * static_cast<double>(header.height);
  const std::string& option = options.max_megapixels_option;
  if (pixels > options.max_megapixels * 1e6) {
    return BadInputError(
        "its header claims " + SizeText(header) + ", more than the limit of " +
        FormatSignificant(options.max_megapixels, 6) + " megapixels" +
        (option.empty()
             ? "; reduce the photo"
             : " (" + option + "); reduce the photo or raise the limit"));
  }
  constexpr int64_t kMaxSide = 1'000'000;  // libpng reads no longer ones.
  if (std::max(header.width, header.height) > kMaxSide) {
    return BadInputError(SizeText(header) + ", longer than " +
                         std::to_string(kMaxSide) +
                         " on a side; reduce or cut it");
  }
  if (std::min(header.width, header.height) < options.min_side) {
    return BadInputError("only " + SizeText(header) + ", shorter than " +
                         std::to_string(options.min_side) +
                         " on a side; remove it");
  }
  if (header.truncated) {
    return BadInputError("truncated " + std::string(FormatName(header.format)) +
                         ": the file ends before its image data does; copy "
                         "the file again");
  }
  if (pixels > header.max_pixels) {
    return BadInputError("its header claims " + SizeText(header) +
                         ", more than its data can hold; copy the file again");
  }
  return Status();
}

StatusOr<ImageU8> DecodePhoto(std::string_view bytes,
                              const PhotoHeader& header,
                              const PhotoDecodeOptions& options) {
  ImageU8 stored;
  if (header.format == PhotoFormat::kJpeg) {
    FREEGS_ASSIGN_OR_RETURN(stored, DecodeJpeg(bytes, header));
  } else {
    FREEGS_ASSIGN_OR_RETURN(cv::Mat mat, DecodeStored(bytes, header));
    FREEGS_ASSIGN_OR_RETURN(stored, ToRgb(std::move(mat), header, options));
  }
  if (header.exif.orientation == 1) return stored;
  return Upright(stored, header.exif.orientation);
}

bool IsPlainPhoto(const PhotoHeader& header) {
  return header.format != PhotoFormat::kTiff && header.plain &&
         header.bits == 8 && !header.has_alpha && header.exif.orientation == 1;
}

InspectedPhoto PhotoInspector::Inspect(const std::filesystem::path& folder,
                                       const std::string& file) {
  InspectedPhoto result;
  result.photo.file = file;
  const std::filesystem::path path = folder / file;
  const StatusOr<std::string> bytes = ReadFile(path, kMaxPhotoFileBytes);
  Status status = bytes.status();
  if (bytes.ok()) {
    result.photo.file_hash = HashBytes(*bytes);
    status = Decode(*bytes, &result);
  } else {
    // The reason stands beside the name already.
    std::string message = status.message();
    const std::string prefix = path.string() + ": ";
    if (message.starts_with(prefix)) message.erase(0, prefix.size());
    std::error_code error;
    const bool large =
        std::filesystem::file_size(path, error) > kMaxPhotoFileBytes && !error;
    status = BadInputError(
        message + (large ? "; reduce it, or remove it"
                         : "; make it a file that you may read, or remove it"));
  }
  if (!status.ok()) {
    result.photo.split = PhotoSplit::kRejected;
    result.photo.reason = status.message();
  }
  return result;
}

Status PhotoInspector::Decode(std::string_view bytes, InspectedPhoto* result) {
  FREEGS_ASSIGN_OR_RETURN(const PhotoHeader header, ParsePhotoHeader(bytes));
  result->photo.format = FormatName(header.format);
  FREEGS_RETURN_IF_ERROR(CheckHeader(header, options_));
  std::unique_lock<std::mutex> lock(large_photo_, std::defer_lock);
  if (header.width * header.height > kLargePhotoPixels) lock.lock();
  FREEGS_ASSIGN_OR_RETURN(ImageU8 pixels, DecodePhoto(bytes, header, options_));
  Photo& photo = result->photo;
  const ExifTags& exif = header.exif;
  photo.width = pixels.width();
  photo.height = pixels.height();
  photo.orientation = exif.orientation;
  photo.sharpness = Sharpness(pixels);
  photo.hash = ContentHash(pixels);
  photo.make = exif.make;
  photo.model = exif.model;
  photo.focal_length_mm = exif.focal_length_mm;
  photo.focal_length_35mm = exif.focal_length_35mm;
  photo.digital_zoom = exif.digital_zoom;
  photo.focal_length_px =
      FocalLengthPixels(exif, pixels.width(), pixels.height());
  result->may_be_transparent = header.has_alpha;
  photo.converted = !IsPlainPhoto(header);
  if (photo.converted) result->pixels = std::move(pixels);
  return Status();
}

}  // namespace freegs::photos
