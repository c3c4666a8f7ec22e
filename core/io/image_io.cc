// SPDX-License-Identifier: BSD-3-Clause

#include "core/io/image_io.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "core/io/files.h"
#include "core/out_of_memory.h"

namespace freegs {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kMaxFileBytes = uint64_t{1} << 30;

struct ClaimedSize {
  uint64_t width = 0;
  uint64_t height = 0;
  uint64_t max_pixels_per_byte = 0;  // That a file can hold.
};

uint64_t BigEndian(std::string_view bytes, size_t at, size_t size) {
  uint64_t value = 0;
  for (size_t i = at; i < at + size; ++i) {
    value = value << 8 | static_cast<uint8_t>(bytes[i]);
  }
  return value;
}

// A pixel has at least one bit, and Deflate makes at most 1032 bytes of one.
ClaimedSize PngSize(std::string_view bytes) {
  constexpr size_t kWidthAt = 16;
  constexpr size_t kEndOfSize = 24;
  if (bytes.size() < kEndOfSize) return {};
  return {BigEndian(bytes, kWidthAt, 4),
          BigEndian(bytes, kWidthAt + 4, 4),
          uint64_t{1032} * 8};
}

// A block of 8 x 8 pixels has at least one bit. What stands in the first frame
// header counts (ITU-T T.81, annex B).
ClaimedSize JpegSize(std::string_view bytes) {
  constexpr size_t kEndOfSize = 9;  // From the marker on.
  size_t at = 2;
  while (at + kEndOfSize <= bytes.size()) {
    const uint64_t marker = BigEndian(bytes, at, 2);
    if (marker < 0xff01 || marker == 0xffff) {
      ++at;  // Decoders skip garbage between segments.
      continue;
    }
    const bool is_frame = marker >= 0xffc0 && marker <= 0xffcf &&
                          marker != 0xffc4 && marker != 0xffc8 &&
                          marker != 0xffcc;
    if (is_frame) {
      return {BigEndian(bytes, at + 7, 2),
              BigEndian(bytes, at + 5, 2),
              uint64_t{64} * 8};
    }
    const bool alone =
        marker == 0xff01 || (marker >= 0xffd0 && marker <= 0xffd8);
    at += 2 + (alone ? 0 : BigEndian(bytes, at + 2, 2));
  }
  return {};
}

bool IsTiff(std::string_view bytes) {
  return bytes.starts_with(std::string_view("II*\0", 4)) ||
         bytes.starts_with(std::string_view("MM\0*", 4));
}

// Sizes of the first picture (TIFF 6.0, section 2). Compressed by Deflate, as
// in a PNG. A size that is no plain number counts as too large.
ClaimedSize TiffSize(std::string_view bytes) {
  constexpr uint64_t kEntryBytes = 12;
  const auto number = [&](uint64_t at, size_t size) -> uint64_t {
    if (at > bytes.size() || size > bytes.size() - at) return 0;
    std::string digits(bytes.substr(at, size));
    if (bytes[0] == 'I') std::reverse(digits.begin(), digits.end());
    return BigEndian(digits, 0, size);
  };
  ClaimedSize claimed{0, 0, uint64_t{1032} * 8};
  const uint64_t directory = number(4, 4);
  const uint64_t entries = number(directory, 2);
  for (uint64_t k = 0; k < entries; ++k) {
    const uint64_t entry = directory + 2 + k * kEntryBytes;
    const uint64_t tag = number(entry, 2);
    if (tag != 256 && tag != 257) continue;
    const uint64_t type = number(entry + 2, 2);
    uint64_t value = uint64_t{1} << 31;
    if (number(entry + 4, 4) == 1) {
      if (type == 3) value = number(entry + 8, 2);
      if (type == 4) value = number(entry + 8, 4);
    }
    uint64_t& side = tag == 256 ? claimed.width : claimed.height;
    side = std::max(side, value);
  }
  return claimed;
}

// OpenCV takes memory for all pixels that a header claims, up to 2^30, before
// it looks for them. So a format whose headers are not looked at is refused.
Status CheckClaimedSize(const fs::path& path, std::string_view bytes) {
  ClaimedSize claimed;
  if (bytes.starts_with("\x89PNG")) {
    claimed = PngSize(bytes);
  } else if (bytes.starts_with("\xff\xd8")) {
    claimed = JpegSize(bytes);
  } else if (IsTiff(bytes)) {
    claimed = TiffSize(bytes);
  } else {
    return BadInputError(path.string() + ": not a PNG, JPEG or TIFF image");
  }
  if (claimed.width * claimed.height <=
      claimed.max_pixels_per_byte * bytes.size()) {
    return Status();
  }
  return BadInputError(path.string() + ": its header claims " +
                       std::to_string(claimed.width) + " x " +
                       std::to_string(claimed.height) +
                       " pixels, more than its data can hold");
}

// OpenCV multiplies the values of a grey PNG of 1, 2 or 4 bits by this, so that
// its white is 255.
int GreyFactor(std::string_view bytes) {
  constexpr size_t kBitsAt = 24;
  constexpr size_t kColorTypeAt = 25;
  if (!bytes.starts_with("\x89PNG") || bytes.size() <= kColorTypeAt) return 1;
  const int bits = static_cast<uint8_t>(bytes[kBitsAt]);
  const bool is_grey = bytes[kColorTypeAt] == 0;
  if (!is_grey || (bits != 1 && bits != 2 && bits != 4)) return 1;
  return 255 / ((1 << bits) - 1);
}

// `bytes` are those of the file.
StatusOr<cv::Mat> Decode(const fs::path& path,
                         const std::string& bytes,
                         int flags) {
  if (bytes.empty()) return BadInputError(path.string() + ": empty file");
  FREEGS_RETURN_IF_ERROR(CheckClaimedSize(path, bytes));
  const cv::Mat buffer(1,
                       static_cast<int>(bytes.size()),
                       CV_8UC1,
                       const_cast<char*>(bytes.data()));
  try {
    cv::Mat image = cv::imdecode(buffer, flags);
    if (image.empty()) {
      return BadInputError(path.string() + ": not a readable image");
    }
    return image;
  } catch (const cv::Exception& e) {
    if (IsOutOfMemory(e)) throw;
    return BadInputError(path.string() + ": not a readable image: " + e.err);
  }
}

// `suffix` names the format.
Status Encode(const fs::path& path,
              const std::string& suffix,
              const cv::Mat& image) {
  std::vector<uint8_t> bytes;
  try {
    const std::vector<int> parameters = {
        cv::IMWRITE_JPEG_QUALITY, 95, cv::IMWRITE_PNG_COMPRESSION, 3};
    if (!cv::imencode(suffix, image, bytes, parameters)) {
      return InternalError(path.string() + ": cannot encode image");
    }
  } catch (const cv::Exception& e) {
    if (IsOutOfMemory(e)) throw;
    return InternalError(path.string() + ": cannot encode image: " + e.err);
  }
  return WriteFileAtomic(
      path, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

}  // namespace

StatusOr<ImageU8> ReadRgb(const fs::path& path) {
  FREEGS_ASSIGN_OR_RETURN(const std::string bytes,
                          ReadFile(path, kMaxFileBytes));
  FREEGS_ASSIGN_OR_RETURN(
      cv::Mat bgr,
      Decode(path, bytes, cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION));
  ImageU8 image(bgr.cols, bgr.rows, 3);
  cv::Mat rgb(bgr.rows, bgr.cols, CV_8UC3, image.data());
  cv::cvtColor(bgr, rgb, cv::COLOR_BGR2RGB);
  return image;
}

StatusOr<ImageU16> ReadLabels(const fs::path& path) {
  FREEGS_ASSIGN_OR_RETURN(const std::string bytes,
                          ReadFile(path, kMaxFileBytes));
  if (IsTiff(bytes)) {
    return BadInputError(path.string() +
                         ": label images are PNG files, this is a TIFF");
  }
  FREEGS_ASSIGN_OR_RETURN(const cv::Mat stored,
                          Decode(path, bytes, cv::IMREAD_UNCHANGED));
  if (stored.channels() != 1 ||
      (stored.depth() != CV_8U && stored.depth() != CV_16U)) {
    return BadInputError(path.string() +
                         ": label images have one 8 or 16 bit channel");
  }
  ImageU16 labels(stored.cols, stored.rows, 1);
  cv::Mat target(stored.rows, stored.cols, CV_16UC1, labels.data());
  stored.convertTo(target, CV_16U, 1.0 / GreyFactor(bytes));
  return labels;
}

Status WriteImage(const fs::path& path, const ImageU8& image) {
  if (!CanWriteImage(path)) {
    return InternalError(path.string() +
                         ": cannot encode image: its name ends with none of "
                         ".png, .jpg, .jpeg, .jpe, .tif, .tiff");
  }
  if (image.empty()) {
    return InternalError(path.string() +
                         ": cannot encode image: it has no pixels");
  }
  const std::string suffix = LowerSuffix(path);
  const cv::Mat stored(image.height(),
                       image.width(),
                       CV_8UC(image.channels()),
                       const_cast<uint8_t*>(image.data()));
  cv::Mat bgr;
  switch (image.channels()) {
    case 1:
      return Encode(path, suffix, stored);
    case 3:
      cv::cvtColor(stored, bgr, cv::COLOR_RGB2BGR);
      return Encode(path, suffix, bgr);
    case 4:
      cv::cvtColor(stored, bgr, cv::COLOR_RGBA2BGRA);
      return Encode(path, suffix, bgr);
    default:
      return InternalError(path.string() + ": images have 1, 3 or 4 channels");
  }
}

bool CanWriteImage(const fs::path& path) {
  constexpr std::array<std::string_view, 6> kSuffixes = {
      ".png", ".jpg", ".jpeg", ".jpe", ".tif", ".tiff"};
  return std::find(kSuffixes.begin(), kSuffixes.end(), LowerSuffix(path)) !=
         kSuffixes.end();
}

Status WriteLabels(const fs::path& path, const ImageU16& labels) {
  return Encode(path,
                ".png",
                cv::Mat(labels.height(),
                        labels.width(),
                        CV_16UC1,
                        const_cast<uint16_t*>(labels.data())));
}

ImageF ToFloat(const ImageU8& image) {
  ImageF result(image.width(), image.height(), image.channels());
  std::transform(
      image.data(), image.data() + image.size(), result.data(), [](uint8_t v) {
        return static_cast<float>(v) / 255.0f;
      });
  return result;
}

ImageU8 ToU8(const ImageF& image) {
  ImageU8 result(image.width(), image.height(), image.channels());
  std::transform(
      image.data(), image.data() + image.size(), result.data(), [](float v) {
        return static_cast<uint8_t>(
            std::lround(std::clamp(v, 0.0f, 1.0f) * 255.0f));
      });
  return result;
}

ImageU8 Resize(const ImageU8& image, int width, int height) {
  if (width == image.width() && height == image.height()) return image;
  ImageU8 result(width, height, image.channels());
  const cv::Mat source(image.height(),
                       image.width(),
                       CV_8UC(image.channels()),
                       const_cast<uint8_t*>(image.data()));
  cv::Mat target(height, width, CV_8UC(image.channels()), result.data());
  const bool smaller = width < image.width() || height < image.height();
  cv::resize(source,
             target,
             target.size(),
             0,
             0,
             smaller ? cv::INTER_AREA : cv::INTER_LINEAR);
  return result;
}

}  // namespace freegs
