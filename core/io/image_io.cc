// SPDX-License-Identifier: BSD-3-Clause

#include "core/io/image_io.h"

#include <algorithm>
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

// OpenCV takes memory for all pixels that a header claims, up to 2^30, before
// it looks for them.
Status CheckClaimedSize(const fs::path& path, std::string_view bytes) {
  ClaimedSize claimed;
  if (bytes.starts_with("\x89PNG")) claimed = PngSize(bytes);
  if (bytes.starts_with("\xff\xd8")) claimed = JpegSize(bytes);
  if (claimed.width * claimed.height <=
      claimed.max_pixels_per_byte * bytes.size()) {
    return Status();
  }
  return BadInputError(path.string() + ": its header claims " +
                       std::to_string(claimed.width) + " x " +
                       std::to_string(claimed.height) +
                       " pixels, more than its data can hold");
}

StatusOr<cv::Mat> Decode(const fs::path& path, int flags) {
  FREEGS_ASSIGN_OR_RETURN(const std::string bytes,
                          ReadFile(path, kMaxFileBytes));
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

Status Encode(const fs::path& path, const cv::Mat& image) {
  std::vector<uint8_t> bytes;
  try {
    const std::vector<int> parameters = {
        cv::IMWRITE_JPEG_QUALITY, 95, cv::IMWRITE_PNG_COMPRESSION, 3};
    if (!cv::imencode(path.extension().string(), image, bytes, parameters)) {
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
  FREEGS_ASSIGN_OR_RETURN(
      cv::Mat bgr,
      Decode(path, cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION));
  ImageU8 image(bgr.cols, bgr.rows, 3);
  cv::Mat rgb(bgr.rows, bgr.cols, CV_8UC3, image.data());
  cv::cvtColor(bgr, rgb, cv::COLOR_BGR2RGB);
  return image;
}

StatusOr<ImageU16> ReadLabels(const fs::path& path) {
  FREEGS_ASSIGN_OR_RETURN(cv::Mat stored, Decode(path, cv::IMREAD_UNCHANGED));
  if (stored.channels() != 1 ||
      (stored.depth() != CV_8U && stored.depth() != CV_16U)) {
    return BadInputError(path.string() +
                         ": label images have one 8 or 16 bit channel");
  }
  ImageU16 labels(stored.cols, stored.rows, 1);
  cv::Mat target(stored.rows, stored.cols, CV_16UC1, labels.data());
  stored.convertTo(target, CV_16U);
  return labels;
}

Status WriteImage(const fs::path& path, const ImageU8& image) {
  const cv::Mat stored(image.height(),
                       image.width(),
                       CV_8UC(image.channels()),
                       const_cast<uint8_t*>(image.data()));
  cv::Mat bgr;
  switch (image.channels()) {
    case 1:
      return Encode(path, stored);
    case 3:
      cv::cvtColor(stored, bgr, cv::COLOR_RGB2BGR);
      return Encode(path, bgr);
    case 4:
      cv::cvtColor(stored, bgr, cv::COLOR_RGBA2BGRA);
      return Encode(path, bgr);
    default:
      return InternalError(path.string() + ": images have 1, 3 or 4 channels");
  }
}

bool CanWriteImage(const fs::path& path) {
  return path.has_extension() && cv::haveImageWriter(path.extension().string());
}

Status WriteLabels(const fs::path& path, const ImageU16& labels) {
  return Encode(path,
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
