// SPDX-License-Identifier: BSD-3-Clause

#include "stages/ingest/ingest_forecast.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <functional>
#include <limits>
#include <system_error>
#include <utility>

#include "core/status.h"
#include "photos/photo_header.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;
using photos::Photo;

// While a photo is read: its file, its pixels as decoded and as upright RGB,
// and a reduced grey copy.
constexpr double kBytesPerPixel = 8;

constexpr double kSeconds = 0.3;
constexpr double kSecondsPerMegapixel = 0.006;

// Size of the PNG file that is written for a photo that other programs might
// read differently.
constexpr double kBytesPerWrittenPixel = 2;

// Reads the header from the first bytes of a file. The whole file is read only
// where it is a photo and these do not have the header, as in most TIFF files.
StatusOr<photos::PhotoHeader> ReadHeader(const fs::path& path) {
  std::error_code error;
  const uint64_t size = fs::file_size(path, error);
  if (error) return BadInputError(error.message());
  if (size > photos::kMaxPhotoFileBytes) return BadInputError("too large");
  std::string bytes;
  StatusOr<photos::PhotoHeader> header = BadInputError("not read");
  for (const uint64_t limit : {uint64_t{1} << 17, size}) {
    bytes.resize(std::min(size, limit));
    std::ifstream file(path, std::ios::binary);
    file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    if (!file) return BadInputError("cannot read");
    header = photos::ParsePhotoHeader(bytes);
    if (header.ok() || !photos::SniffFormat(bytes).ok() ||
        bytes.size() == size) {
      break;
    }
  }
  if (!header.ok()) return header;
  // These are about the part of the file that was not read.
  header->truncated = false;
  header->max_pixels = std::numeric_limits<double>::infinity();
  return header;
}

}  // namespace

std::vector<Photo> ReadPhotoHeaders(const fs::path& folder,
                                    const std::vector<std::string>& files,
                                    const photos::PhotoDecodeOptions& options) {
  std::vector<Photo> photos;
  for (const std::string& file : files) {
    const auto header = ReadHeader(folder / file);
    if (!header.ok() || !photos::CheckHeader(*header, options).ok()) continue;
    Photo& photo = photos.emplace_back();
    photo.file = photo.name = file;
    photo.width = static_cast<int>(header->width);
    photo.height = static_cast<int>(header->height);
    photo.converted = !photos::IsPlainPhoto(*header);
  }
  return photos;
}

void AddPhotosTo(const std::vector<Photo>& photos,
                 const fs::path& folder,
                 pipeline::SceneOutlook* scene) {
  for (const Photo& photo : photos) {
    if (!photo.usable()) continue;
    View view;
    view.name = photo.name;
    view.camera.width = photo.width;
    view.camera.height = photo.height;
    std::error_code error;
    const uintmax_t size = fs::file_size(folder / photo.name, error);
    if (photo.converted) {
      scene->photo_bytes +=
          std::llround(kBytesPerWrittenPixel * photo.width * photo.height);
    } else if (!error) {
      scene->photo_bytes += static_cast<int64_t>(size);
    }
    scene->masks = scene->masks || photo.has_mask;
    const bool holdout = photo.split == photos::PhotoSplit::kHoldout;
    (holdout ? scene->holdout : scene->train).push_back(std::move(view));
  }
}

pipeline::StageNeed IngestNeed(const pipeline::SceneOutlook& scene,
                               int threads) {
  std::vector<double> pixels;
  for (const auto* views : {&scene.train, &scene.holdout}) {
    for (const View& view : *views) {
      pixels.push_back(static_cast<double>(view.camera.width) *
                       view.camera.height);
    }
  }
  if (pixels.empty()) return {};
  std::sort(pixels.begin(), pixels.end(), std::greater<>());
  double at_once = 0;
  double megapixels = 0;
  for (size_t i = 0; i < pixels.size(); ++i) {
    if (i < static_cast<size_t>(threads)) at_once += pixels[i];
    megapixels += pixels[i] / 1e6;
  }
  return {.memory_bytes =
              pipeline::kProgramMemory + std::llround(kBytesPerPixel * at_once),
          .disk_bytes = scene.photo_bytes,
          .seconds = kSeconds + kSecondsPerMegapixel * megapixels / threads,
          .advice =
              "lower general.threads, or ingest.max_megapixels so that the "
              "largest photos are left out"};
}

}  // namespace freegs::stages
