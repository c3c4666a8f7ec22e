// SPDX-License-Identifier: BSD-3-Clause

#include "splat/images/training_images.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <system_error>
#include <utility>

#include "core/io/image_io.h"

namespace freegs::splat {
namespace {

Pinhole AtLevel(const Pinhole& camera, int max_side, int level) {
  const Pinhole full = camera.LimitedTo(max_side);
  const auto side = [level](int full_side) {
    const double scaled = std::ldexp(static_cast<double>(full_side), -level);
    return std::max(1, static_cast<int>(std::lround(scaled)));
  };
  return full.Resized(side(full.width), side(full.height));
}

std::string SizeText(int width, int height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

// kBadInput, naming the file, unless a picture has the size of its camera.
template <typename T>
Status CheckSize(const std::filesystem::path& path,
                 const Image<T>& picture,
                 const Pinhole& camera) {
  if (picture.width() == camera.width && picture.height() == camera.height) {
    return Status();
  }
  return BadInputError(
      path.string() + ": is " + SizeText(picture.width(), picture.height()) +
      " pixels, its camera says " + SizeText(camera.width, camera.height));
}

// Ignores what is not wholly used.
void KeepWhole(ImageU8* mask) {
  std::transform(
      mask->data(), mask->data() + mask->size(), mask->data(), [](uint8_t v) {
        return uint8_t{v == 255 ? v : uint8_t{0}};
      });
}

}  // namespace

Status TrainingImagesOptions::Check() const {
  if (max_side < 0) {
    return InvalidArgumentError("max_side of training images must be >= 0");
  }
  if (num_levels < 1 || num_levels > 16) {
    return InvalidArgumentError("num_levels must be from 1 to 16");
  }
  return Status();
}

StatusOr<TrainingImages> TrainingImages::Load(
    std::span<const View> views,
    const std::filesystem::path& folder,
    const TrainingImagesOptions& options,
    ThreadPool& pool,
    const CancellationToken* cancellation) {
  FREEGS_RETURN_IF_ERROR(options.Check());
  TrainingImages images;
  images.options_ = options;
  images.folder_ = folder;
  Cache& cache = *images.cache_;
  cache.entries.resize(views.size());
  for (size_t i = 0; i < views.size(); ++i) {
    cache.entries[i].view = views[i];
    images.indices_.push_back(i);
  }

  // Photos are read in batches, so that memory holds no more than one photo of
  // each thread beyond max_bytes.
  const auto count = static_cast<int64_t>(views.size());
  const int64_t batch = pool.num_threads();
  for (int64_t begin = 0; begin < count; begin += batch) {
    if (IsCancelled(cancellation)) {
      return InterruptedError("stopped while reading photos");
    }
    const int64_t end = std::min(count, begin + batch);
    std::vector<std::optional<StatusOr<Pyramid>>> read(end - begin);
    pool.ParallelFor(begin, end, 1, [&](int64_t first, int64_t last, int) {
      for (int64_t i = first; i < last; ++i) {
        read[i - begin] = images.ReadPyramid(static_cast<size_t>(i));
      }
    });
    for (int64_t i = begin; i < end; ++i) {
      FREEGS_ASSIGN_OR_RETURN(Pyramid pyramid, *std::move(read[i - begin]));
      const uint64_t bytes = pyramid.Bytes();
      if (cache.held_bytes + bytes > options.max_bytes) continue;
      cache.entries[i].pyramid =
          std::make_unique<const Pyramid>(std::move(pyramid));
      cache.held_bytes += bytes;
    }
  }
  return images;
}

TrainingImages TrainingImages::Subset(std::span<const size_t> indices) const {
  TrainingImages subset;
  subset.options_ = options_;
  subset.folder_ = folder_;
  subset.cache_ = cache_;
  for (const size_t index : indices) {
    subset.indices_.push_back(indices_[index]);
  }
  return subset;
}

uint64_t TrainingImages::Pyramid::Bytes() const {
  uint64_t bytes = 0;
  for (const std::vector<ImageU8>* levels : {&photo, &mask}) {
    for (const ImageU8& image : *levels) bytes += image.size();
  }
  return bytes;
}

View TrainingImages::view(size_t index, int level) const {
  View view = entry(index).view;
  view.camera = camera(index, level);
  return view;
}

Pinhole TrainingImages::camera(size_t index, int level) const {
  return AtLevel(entry(index).view.camera, options_.max_side, level);
}

Status TrainingImages::Fetch(size_t index, int level, ImageF* image) {
  Entry& fetched = entry(index);
  fetched.last_use = ++cache_->clock;
  if (!fetched.pyramid) {
    FREEGS_ASSIGN_OR_RETURN(Pyramid pyramid, ReadPyramid(index));
    fetched.pyramid = std::make_unique<const Pyramid>(std::move(pyramid));
    cache_->held_bytes += fetched.pyramid->Bytes();
    DropOthers(fetched);
  }
  const ImageU8& stored = fetched.pyramid->photo[level];
  image->Reshape(stored.width(), stored.height(), stored.channels());
  std::transform(stored.data(),
                 stored.data() + stored.size(),
                 image->data(),
                 [](uint8_t v) { return static_cast<float>(v) / 255.0f; });
  return Status();
}

const ImageU8* TrainingImages::Mask(size_t index, int level) const {
  const std::unique_ptr<const Pyramid>& pyramid = entry(index).pyramid;
  if (!pyramid || pyramid->mask.empty()) return nullptr;
  return &pyramid->mask[level];
}

StatusOr<TrainingImages::Pyramid> TrainingImages::ReadPyramid(
    size_t index) const {
  const View& view = entry(index).view;
  const std::filesystem::path path = folder_ / view.name;
  FREEGS_ASSIGN_OR_RETURN(const ImageU8 photo, ReadRgb(path));
  FREEGS_RETURN_IF_ERROR(CheckSize(path, photo, view.camera));
  Pyramid pyramid;
  for (int level = 0; level < options_.num_levels; ++level) {
    const Pinhole camera = AtLevel(view.camera, options_.max_side, level);
    // Every level is averaged from level 0, so that errors of rounding to 8
    // bits do not add up along the pyramid.
    pyramid.photo.push_back(Resize(
        level == 0 ? photo : pyramid.photo[0], camera.width, camera.height));
  }
  if (!options_.mask_folder.empty()) {
    FREEGS_RETURN_IF_ERROR(ReadMask(index, &pyramid));
  }
  return pyramid;
}

Status TrainingImages::ReadMask(size_t index, Pyramid* pyramid) const {
  const View& view = entry(index).view;
  const std::filesystem::path path =
      options_.mask_folder / (view.name + ".png");
  std::error_code error;
  if (!std::filesystem::exists(path, error)) return Status();
  FREEGS_ASSIGN_OR_RETURN(const ImageU16 labels, ReadLabels(path));
  FREEGS_RETURN_IF_ERROR(CheckSize(path, labels, view.camera));
  ImageU8 mask(labels.width(), labels.height(), 1);
  std::transform(
      labels.data(),
      labels.data() + labels.size(),
      mask.data(),
      [](uint16_t v) { return uint8_t{v != 0 ? uint8_t{255} : uint8_t{0}}; });
  for (int level = 0; level < options_.num_levels; ++level) {
    const Pinhole camera = AtLevel(view.camera, options_.max_side, level);
    // As for photos, the finest level is what the others average.
    pyramid->mask.push_back(Resize(
        level == 0 ? mask : pyramid->mask[0], camera.width, camera.height));
    KeepWhole(&pyramid->mask.back());
  }
  return Status();
}

void TrainingImages::DropOthers(const Entry& keep) {
  while (cache_->held_bytes > options_.max_bytes) {
    Entry* dropped = nullptr;
    for (Entry& entry : cache_->entries) {
      if (&entry == &keep || !entry.pyramid) continue;
      if (dropped == nullptr ||
          (options_.fetched_in_order ? entry.last_use > dropped->last_use
                                     : entry.last_use < dropped->last_use)) {
        dropped = &entry;
      }
    }
    if (dropped == nullptr) return;
    cache_->held_bytes -= dropped->pyramid->Bytes();
    dropped->pyramid.reset();
  }
}

}  // namespace freegs::splat
