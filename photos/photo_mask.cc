// SPDX-License-Identifier: BSD-3-Clause

#include "photos/photo_mask.h"

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <system_error>

#include "photos/photo_header.h"
#include "photos/photo_pixels.h"

namespace freegs::photos {
namespace {

namespace fs = std::filesystem;

constexpr uint8_t kIgnore = 0;
constexpr uint8_t kKeep = 255;

std::string SizeText(int width, int height) {
  return std::to_string(width) + " x " + std::to_string(height);
}

bool HasShapeOf(const Photo& photo, const ImageU8& mask) {
  return SameShape(mask.width(), mask.height(), photo.width, photo.height);
}

// The value of the pixel whose centre is nearest.
ImageU8 ResizeNearest(const ImageU8& image, int width, int height) {
  ImageU8 result(width, height, 1);
  for (int y = 0; y < height; ++y) {
    const int from_y = static_cast<int>((y + 0.5) * image.height() / height);
    for (int x = 0; x < width; ++x) {
      const int from_x = static_cast<int>((x + 0.5) * image.width() / width);
      result(x, y) = image(std::min(from_x, image.width() - 1),
                           std::min(from_y, image.height() - 1));
    }
  }
  return result;
}

}  // namespace

std::optional<std::string> FindMask(const fs::path& folder,
                                    const std::string& photo_file) {
  const std::string stem = fs::path(photo_file).replace_extension().string();
  for (const std::string& name : {photo_file + ".png", stem + ".png"}) {
    std::error_code error;
    if (fs::is_regular_file(folder / name, error)) return name;
  }
  return std::nullopt;
}

std::vector<std::optional<std::string>> FindMasks(
    const fs::path& folder, const std::vector<std::string>& photo_files) {
  std::vector<std::optional<std::string>> masks;
  std::map<std::string, int> takers;  // The photos that could take a mask.
  std::vector<size_t> indirect;
  for (const std::string& file : photo_files) {
    std::optional<std::string> mask = FindMask(folder, file);
    const size_t slash = file.find('/');
    if (!mask && slash != std::string::npos) {
      mask = FindMask(folder, file.substr(slash + 1));
      if (mask) indirect.push_back(masks.size());
    }
    if (mask) ++takers[*mask];
    masks.push_back(std::move(mask));
  }
  for (const size_t i : indirect) {
    if (takers[*masks[i]] > 1) masks[i].reset();
  }
  return masks;
}

StatusOr<ImageU8> DecodeMask(std::string_view bytes,
                             const Photo& photo,
                             bool invert,
                             const PhotoDecodeOptions& options) {
  PhotoDecodeOptions decode = options;
  decode.background = "black";
  decode.only_zero_is_black = true;
  FREEGS_ASSIGN_OR_RETURN(const PhotoHeader header, ParsePhotoHeader(bytes));
  FREEGS_RETURN_IF_ERROR(CheckHeader(header, decode));
  FREEGS_ASSIGN_OR_RETURN(const ImageU8 rgb,
                          DecodePhoto(bytes, header, decode));
  const int least = header.format == PhotoFormat::kJpeg ? 128 : 1;
  ImageU8 mask(rgb.width(), rgb.height(), 1);
  for (int y = 0; y < rgb.height(); ++y) {
    for (int x = 0; x < rgb.width(); ++x) {
      const int value = std::max({rgb(x, y, 0), rgb(x, y, 1), rgb(x, y, 2)});
      mask(x, y) = (value >= least) != invert ? kKeep : kIgnore;
    }
  }
  // The nearer shape tells, because an almost square photo has about the shape
  // of the one that is stored.
  const auto distance = [&mask](int64_t width, int64_t height) {
    return std::abs(mask.width() * height - mask.height() * width);
  };
  if (photo.orientation >= 5 && distance(photo.height, photo.width) <
                                    distance(photo.width, photo.height)) {
    mask = Upright(mask, photo.orientation);
  }
  if (!HasShapeOf(photo, mask)) {
    return BadInputError("the mask has " + SizeText(rgb.width(), rgb.height()) +
                         " pixels and the photo " +
                         SizeText(photo.width, photo.height) +
                         ": another shape; make it anew from this photo");
  }
  if (mask.width() == photo.width && mask.height() == photo.height) return mask;
  return ResizeNearest(mask, photo.width, photo.height);
}

double KeptShare(const ImageU8& mask) {
  if (mask.empty()) return 0;
  const auto kept = std::count(mask.data(), mask.data() + mask.size(), kKeep);
  return static_cast<double>(kept) / static_cast<double>(mask.size());
}

}  // namespace freegs::photos
