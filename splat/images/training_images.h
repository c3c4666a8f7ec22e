// SPDX-License-Identifier: BSD-3-Clause
// The photographs that training compares its renderings with, at several sizes.
//
//   FREEGS_ASSIGN_OR_RETURN(
//       TrainingImages images,
//       TrainingImages::Load(views, "scene/images", {.max_side = 1600}, pool));
//   ImageF photo;
//   FREEGS_RETURN_IF_ERROR(images.Fetch(0, 1, &photo));  // View 0, half size.

#ifndef FREEGS_SPLAT_IMAGES_TRAINING_IMAGES_H_
#define FREEGS_SPLAT_IMAGES_TRAINING_IMAGES_H_

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <vector>

#include "core/cancellation.h"
#include "core/image.h"
#include "core/parallel.h"
#include "core/pinhole.h"
#include "core/status.h"

namespace freegs::splat {

struct TrainingImagesOptions {
  // The longest side of level 0 in pixels; larger photos are reduced to it. 0
  // keeps the photos' own size.
  int max_side = 0;

  // Number of levels of the image pyramid. The sides of level k are those of
  // level 0 divided by 2^k and rounded.
  int num_levels = 3;

  // The most bytes that decoded photos may take in memory. When there are more,
  // the photos that were not used for longest are dropped, and read again when
  // they are needed. One photo is always kept.
  uint64_t max_bytes = uint64_t{4} << 30;

  // For photos that are fetched again and again in the same order. Those that
  // were not used for longest are then needed soonest, so those that were used
  // last are dropped instead.
  bool fetched_in_order = false;

  // The folder of masks, NAME.png for the photo NAME: one channel of the
  // photo's size, 0 for pixels to ignore. A photo without a file has no mask.
  // Empty: no photo has one.
  std::filesystem::path mask_folder = {};

  Status Check() const;
};

// Photos are kept as pyramids of 8-bit images that are reduced by averaging
// areas. What Fetch returns does not depend on max_bytes or on earlier calls.
class TrainingImages {
 public:
  // Reads folder / view.name for every view, to find unreadable photos now and
  // not in the middle of training. Fails with kBadInput when a photo cannot be
  // read or does not have its camera's size, and with kInterrupted when
  // `cancellation` (null: never) asks to stop.
  static StatusOr<TrainingImages> Load(
      std::span<const View> views,
      const std::filesystem::path& folder,
      const TrainingImagesOptions& options,
      ThreadPool& pool,
      const CancellationToken* cancellation = nullptr);

  // The photos at `indices`, in that order. The two share what is in memory and
  // its limit, so only one of them may be used at a time.
  TrainingImages Subset(std::span<const size_t> indices) const;

  size_t size() const { return indices_.size(); }
  int num_levels() const { return options_.num_levels; }
  // Whether there is a folder of masks. Without it Mask is null for every
  // photo, whether fetched or not.
  bool may_have_masks() const { return !options_.mask_folder.empty(); }

  // A view whose camera is resized to a level, and its parts. index < size(),
  // 0 <= level < num_levels().
  View view(size_t index, int level = 0) const;
  Pinhole camera(size_t index, int level) const;
  const Rigid3d& cam_from_world(size_t index) const {
    return entry(index).view.cam_from_world;
  }

  // Writes the photo at a level to *image: H x W x 3 in [0, 1], of the size of
  // view(index, level). Only one thread may call it at a time. Fails only when
  // a dropped photo has become unreadable or changed its size since Load.
  Status Fetch(size_t index, int level, ImageF* image);

  // The mask of the photo that was fetched last, at a level: one channel of the
  // size of view(index, level), 0 (ignore) or 255 (use). A pixel is used if all
  // that it averages is, but for what makes less than 0.2 % of it, as at the
  // border of areas of a fraction of a pixel. Null if the photo has no mask.
  // Valid until the next Fetch.
  const ImageU8* Mask(size_t index, int level) const;

 private:
  // A photo at all levels, and its mask if it has one.
  struct Pyramid {
    std::vector<ImageU8> photo;
    std::vector<ImageU8> mask;
    uint64_t Bytes() const;
  };
  struct Entry {
    View view;  // As given to Load: the photo's own size.
    std::unique_ptr<const Pyramid> pyramid;  // Null when dropped.
    uint64_t last_use = 0;
  };
  struct Cache {
    std::vector<Entry> entries;
    uint64_t held_bytes = 0;  // Size of all pyramids in entries.
    uint64_t clock = 0;
  };

  TrainingImages() = default;
  Entry& entry(size_t index) const { return cache_->entries[indices_[index]]; }
  StatusOr<Pyramid> ReadPyramid(size_t index) const;
  Status ReadMask(size_t index, Pyramid* pyramid) const;
  void DropOthers(const Entry& keep);

  TrainingImagesOptions options_;
  std::filesystem::path folder_;
  std::shared_ptr<Cache> cache_ = std::make_shared<Cache>();
  std::vector<size_t> indices_;  // In the cache's entries.
};

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_IMAGES_TRAINING_IMAGES_H_
