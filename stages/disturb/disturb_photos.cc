// SPDX-License-Identifier: BSD-3-Clause

#include "stages/disturb/disturb_photos.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "core/io/files.h"
#include "core/number_text.h"
#include "core/pinhole.h"
#include "core/random.h"
#include "photos/photo_decode.h"
#include "photos/photo_exif.h"
#include "photos/photo_header.h"
#include "photos/photo_jpeg.h"
#include "photos/photo_mask.h"
#include "photos/photo_scan.h"
#include "stages/disturb/disturb_pixels.h"
#include "stages/disturb/exif_block.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;
using Kind = DisturbanceKind;
using photos::PhotoFormat;

// Streams of random numbers.
constexpr uint64_t kChoice = 1;  // Which photographs, and in which order.
constexpr uint64_t kPixels = 2;  // What happens to each.

constexpr int kUsualQuality = 95;

// The photographs of a folder.
struct FoundPhotos {
  std::vector<std::string> usable;

  // Those that stage ingest would leave out by their headers.
  std::vector<std::string> rejected;
};

// A photograph of the folder, and what it is called in the new one.
struct NewPhoto {
  std::string file;
  std::string name;
};

// Files that cannot be read are left out.
FoundPhotos Found(const fs::path& folder,
                  const std::vector<std::string>& files) {
  FoundPhotos found;
  for (const std::string& file : files) {
    const StatusOr<std::string> bytes =
        ReadFile(folder / file, photos::kMaxPhotoFileBytes);
    if (!bytes.ok()) continue;
    const auto header = photos::ParsePhotoHeader(*bytes);
    const bool usable = header.ok() && photos::CheckHeader(*header, {}).ok();
    (usable ? found.usable : found.rejected).push_back(file);
  }
  return found;
}

// 0 to count - 1 in a random order.
std::vector<size_t> RandomOrder(size_t count, uint64_t seed) {
  std::vector<size_t> order(count);
  std::iota(order.begin(), order.end(), size_t{0});
  RandomStream random(seed, kChoice);
  for (size_t i = count; i > 1; --i) {
    std::swap(order[i - 1], order[random.Index(i)]);
  }
  return order;
}

std::vector<NewPhoto> Unchanged(const std::vector<std::string>& files) {
  std::vector<NewPhoto> photos;
  for (const std::string& file : files) photos.push_back({file, file});
  return photos;
}

// The photographs without `missing` of them.
std::vector<NewPhoto> Dropped(const std::vector<std::string>& files,
                              double share,
                              uint64_t seed) {
  std::vector<size_t> order = RandomOrder(files.size(), seed);
  const auto missing = static_cast<size_t>(
      std::lround(share * static_cast<double>(files.size())));
  order.resize(files.size() - std::min(missing, files.size()));
  std::sort(order.begin(), order.end());
  std::vector<NewPhoto> photos;
  for (const size_t i : order) photos.push_back({files[i], files[i]});
  return photos;
}

// `count` photographs, one after another, beginning with a random one.
std::vector<NewPhoto> Neighbours(const std::vector<std::string>& files,
                                 size_t count,
                                 uint64_t seed) {
  if (files.size() <= count) return Unchanged(files);
  const size_t first = RandomIndex(seed, kChoice, 0, files.size() - count + 1);
  std::vector<NewPhoto> photos;
  for (size_t i = first; i < first + count; ++i) {
    photos.push_back({files[i], files[i]});
  }
  return photos;
}

std::vector<NewPhoto> Shuffled(const std::vector<std::string>& files,
                               uint64_t seed) {
  constexpr size_t kDigits = 4;
  std::vector<NewPhoto> photos;
  for (const size_t i : RandomOrder(files.size(), seed)) {
    std::string number = std::to_string(photos.size() + 1);
    number.insert(0, kDigits - std::min(kDigits, number.size()), '0');
    photos.push_back({files[i], number + "/" + files[i]});
  }
  return photos;
}

// kBadInput where an amount is so small, or so large, that no photograph would
// be missing. A share of 0 says so itself.
Status CheckLeavesOut(const Disturbance& disturbance,
                      size_t before,
                      size_t after) {
  if (after < before) return Status();
  const std::string all = std::to_string(before) + " photographs";
  const std::string amount = FormatSignificant(disturbance.amount, 7);
  if (disturbance.kind == Kind::kDrop && disturbance.amount > 0) {
    return BadInputError("drop:" + amount + " leaves out none of " + all);
  }
  if (disturbance.kind == Kind::kViews) {
    return BadInputError("views:" + amount + " leaves out none of " + all);
  }
  return Status();
}

std::vector<NewPhoto> ChoosePhotos(const Disturbance& disturbance,
                                   const std::vector<std::string>& files,
                                   uint64_t seed) {
  switch (disturbance.kind) {
    case Kind::kDrop:
      return Dropped(files, disturbance.amount, seed);
    case Kind::kViews:
      return Neighbours(files, static_cast<size_t>(disturbance.amount), seed);
    case Kind::kShuffle:
      return Shuffled(files, seed);
    default:
      return Unchanged(files);
  }
}

// The pixels of a JPEG or PNG as they are stored, in 3 channels, RGB.
StatusOr<ImageU8> StoredPixels(std::string_view bytes,
                               const photos::PhotoHeader& header) {
  if (header.format == PhotoFormat::kJpeg) {
    return photos::DecodeJpeg(bytes, header);
  }
  const std::string essential = photos::EssentialPng(bytes);
  const cv::Mat data(1,
                     static_cast<int>(essential.size()),
                     CV_8U,
                     const_cast<char*>(essential.data()));
  const cv::Mat bgr =
      cv::imdecode(data, cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION);
  if (bgr.empty()) return BadInputError("it cannot be decoded");
  ImageU8 pixels(bgr.cols, bgr.rows, 3);
  cv::Mat rgb(bgr.rows, bgr.cols, CV_8UC3, pixels.data());
  cv::cvtColor(bgr, rgb, cv::COLOR_BGR2RGB);
  return pixels;
}

StatusOr<std::string> Encoded(ImageU8& pixels, bool jpeg, int quality) {
  const cv::Mat rgb(pixels.height(), pixels.width(), CV_8UC3, pixels.data());
  cv::Mat bgr;
  cv::cvtColor(rgb, bgr, cv::COLOR_RGB2BGR);
  std::vector<uint8_t> bytes;
  if (!cv::imencode(jpeg ? ".jpg" : ".png",
                    bgr,
                    bytes,
                    {cv::IMWRITE_JPEG_QUALITY, quality})) {
    return InternalError("it cannot be encoded");
  }
  return std::string(bytes.begin(), bytes.end());
}

// The file of a photograph with other pixels. Where its pixels are damaged it
// stays as it is: stage ingest leaves it out.
StatusOr<std::string> WithOtherPixels(const Disturbance& disturbance,
                                      const PhotoTurn& turn,
                                      const std::string& bytes) {
  FREEGS_ASSIGN_OR_RETURN(const photos::PhotoHeader header,
                          photos::ParsePhotoHeader(bytes));
  if (header.format == PhotoFormat::kTiff) {
    return BadInputError("a TIFF; convert it to JPEG or PNG");
  }
  if (header.has_alpha) {
    return BadInputError("a transparent PNG; lay it over a background");
  }
  StatusOr<ImageU8> stored = StoredPixels(bytes, header);
  if (!stored.ok()) return bytes;
  ImageU8 pixels = *std::move(stored);
  DisturbPixels(disturbance, turn, &pixels);
  const bool compress = disturbance.kind == Kind::kJpeg;
  FREEGS_ASSIGN_OR_RETURN(
      const std::string file,
      Encoded(pixels,
              compress || header.format == PhotoFormat::kJpeg,
              compress ? static_cast<int>(disturbance.amount) : kUsualQuality));
  return WithExifBlock(file, ExifBlockOf(bytes));
}

// The file of a photograph with another focal length in its EXIF. kBadInput for
// one that would not be read, because the photograph would be as it was.
StatusOr<std::string> WithOtherFocal(double factor, const std::string& bytes) {
  FREEGS_ASSIGN_OR_RETURN(const photos::PhotoHeader header,
                          photos::ParsePhotoHeader(bytes));
  const auto width = static_cast<int>(header.width);
  const auto height = static_cast<int>(header.height);
  const double longest = std::max(width, height);
  const double focal =
      photos::FocalLengthPixels(header.exif, width, height).value_or(longest);
  const double ratio = factor * focal / longest;
  const std::string block = ExifBlockWithFocal(header.exif, ratio);
  if (!photos::FocalLengthPixels(photos::ParseExif(block), width, height)) {
    return BadInputError("its focal length would be " +
                         FormatSignificant(ratio, 3) +
                         " times the longest side; from " +
                         FormatSignificant(kMinFocalRatio, 3) + " to " +
                         FormatSignificant(kMaxFocalRatio, 3) + " is read");
  }
  return WithExifBlock(bytes, block);
}

StatusOr<std::string> Disturbed(const Disturbance& disturbance,
                                const PhotoTurn& turn,
                                std::string bytes) {
  if (ChangesPixels(disturbance.kind)) {
    return WithOtherPixels(disturbance, turn, bytes);
  }
  if (disturbance.kind == Kind::kFocal) {
    return WithOtherFocal(disturbance.amount, bytes);
  }
  return bytes;
}

Status CopyMask(const fs::path& from,
                const std::optional<std::string>& mask,
                const NewPhoto& photo,
                const fs::path& to) {
  if (!mask) return Status();
  FREEGS_ASSIGN_OR_RETURN(const std::string bytes, ReadFile(from / *mask));
  const fs::path target = to / (photo.name + ".png");
  FREEGS_RETURN_IF_ERROR(CreateFolders(target.parent_path()));
  return WriteFileAtomic(target, bytes);
}

}  // namespace

Status DisturbPhotos(const Disturbance& disturbance,
                     const fs::path& images,
                     const fs::path& out,
                     uint64_t seed,
                     const CancellationToken* cancellation) {
  std::error_code error;
  if (fs::is_regular_file(images, error)) {
    return BadInputError(images.string() +
                         ": photographs can be disturbed, films cannot");
  }
  const fs::path masks = images / "masks";
  FREEGS_ASSIGN_OR_RETURN(const photos::PhotoScan scan,
                          photos::ScanPhotos(images, {masks}));
  const FoundPhotos files = Found(images, scan.files);
  const std::vector<NewPhoto> chosen =
      ChoosePhotos(disturbance, files.usable, seed);
  if (chosen.empty()) {
    return BadInputError(images.string() + ": no photographs are left of " +
                         std::to_string(files.usable.size()) +
                         " that can be used");
  }
  FREEGS_RETURN_IF_ERROR(
      CheckLeavesOut(disturbance, files.usable.size(), chosen.size())
          .Annotated(images.string()));
  const std::vector<std::optional<std::string>> found =
      photos::FindMasks(masks, scan.files);
  std::map<std::string, std::optional<std::string>> mask_of;
  for (size_t i = 0; i < found.size(); ++i) mask_of[scan.files[i]] = found[i];
  const auto write = [&](const NewPhoto& photo, const std::string& bytes) {
    const fs::path target = out / photo.name;
    FREEGS_RETURN_IF_ERROR(CreateFolders(target.parent_path()));
    FREEGS_RETURN_IF_ERROR(WriteFileAtomic(target, bytes));
    return CopyMask(masks, mask_of[photo.file], photo, out / "masks");
  };
  for (size_t i = 0; i < chosen.size(); ++i) {
    if (IsCancelled(cancellation)) {
      return InterruptedError("stopped while disturbing photographs");
    }
    const NewPhoto& photo = chosen[i];
    FREEGS_ASSIGN_OR_RETURN(std::string bytes, ReadFile(images / photo.file));
    PhotoTurn turn;
    turn.along = chosen.size() < 2 ? 0.5
                                   : static_cast<double>(i) /
                                         static_cast<double>(chosen.size() - 1);
    turn.seed = RandomBits(seed, kPixels, i);
    const StatusOr<std::string> disturbed =
        Disturbed(disturbance, turn, std::move(bytes));
    if (!disturbed.ok()) {
      return disturbed.status().Annotated((images / photo.file).string());
    }
    FREEGS_RETURN_IF_ERROR(write(photo, *disturbed));
  }
  // Stage ingest says of these what it says without the disturbance.
  for (const NewPhoto& photo : Unchanged(files.rejected)) {
    FREEGS_ASSIGN_OR_RETURN(const std::string bytes,
                            ReadFile(images / photo.file));
    FREEGS_RETURN_IF_ERROR(write(photo, bytes));
  }
  return Status();
}

}  // namespace freegs::stages
