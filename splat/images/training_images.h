// SPDX-License-Identifier: BSD-3-Clause
// The photographs that training compares against, at the sizes it asks for.

#ifndef FREEGS_SPLAT_IMAGES_TRAINING_IMAGES_H_
#define FREEGS_SPLAT_IMAGES_TRAINING_IMAGES_H_

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "core/image.h"
#include "core/parallel.h"
#include "core/pinhole.h"
#include "core/status.h"

namespace freegs::splat {

struct TrainingImagesOptions {
  // Longest side of level 0 in pixels; 0 keeps the photos' own size.
  int max_side = 0;

  // Levels of the pyramid; level k has sides 1 / 2^k of level 0, rounded.
  int num_levels = 3;

  // Bytes of decoded photos held in memory; beyond it the least recently used
  // are dropped and read again when asked for. One photo is always held.
  uint64_t max_bytes = uint64_t{4} << 30;

  Status Check() const;
};

// Photos are held as 8-bit pyramids (area averaging). What Fetch returns does
// not depend on max_bytes or on earlier calls.
class TrainingImages {
 public:
  // Reads folder / view.name for every view, once, to find unreadable photos
  // now and not in the middle of training. kBadInput when one cannot be read or
  // is not of its camera's size.
  static StatusOr<TrainingImages> Load(std::span<const View> views,
                                       const std::filesystem::path& folder,
                                       const TrainingImagesOptions& options,
                                       ThreadPool& pool);

  size_t size() const { return entries_.size(); }
  int num_levels() const { return options_.num_levels; }

  // The view with its camera resized to a level. index < size(),
  // 0 <= level < num_levels().
  View view(size_t index, int level = 0) const;
  // Its parts, without a copy of the name.
  Pinhole camera(size_t index, int level) const;
  const Rigid3d& cam_from_world(size_t index) const {
    return entries_[index].view.cam_from_world;
  }

  // The photo at a level: H x W x 3 in [0, 1], of view(index, level)'s size.
  // Not for concurrent calls. Fails only when a dropped photo has since become
  // unreadable or changed its size.
  Status Fetch(size_t index, int level, ImageF* image);

 private:
  struct Entry {
    View view;                     // As given, with the photo's own size.
    std::vector<ImageU8> pyramid;  // Empty when dropped.
    uint64_t last_use = 0;
  };

  TrainingImages() = default;
  StatusOr<std::vector<ImageU8>> ReadPyramid(size_t index) const;
  void DropLeastRecent(size_t keep);

  TrainingImagesOptions options_;
  std::filesystem::path folder_;
  std::vector<Entry> entries_;
  uint64_t held_bytes_ = 0;  // Of all pyramids in entries_.
  uint64_t clock_ = 0;
};

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_IMAGES_TRAINING_IMAGES_H_
