// SPDX-License-Identifier: BSD-3-Clause
// How large the images must be that features are taken from.
//
// Of the features found, the largest max_features are kept. Where a large image
// has several times as many, the finest ones, which take most of the time, are
// found to be thrown away; a smaller image has the large ones too.

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/quantile.h"
#include "sfm/colmap/colmap_steps.h"
#include "sfm/matching/match_database.h"

namespace freegs::sfm {
namespace {

namespace fs = std::filesystem;

constexpr int kSamplePhotos = 4;
constexpr int kSmallest = 800;
constexpr int kLargest = 1600;

// Features that are enough in an image, as a share of max_features: the last of
// them are the finest, which cost most and are found again least.
constexpr double kEnough = 0.8;

// All features of a few of the photos, evenly chosen, at the smallest size.
StatusOr<std::vector<int64_t>> CountFeatures(const StepContext& context) {
  SfmInput input = context.input;
  input.progress = nullptr;
  input.photos.clear();
  const size_t count = context.input.photos.size();
  const size_t sampled = std::min<size_t>(count, kSamplePhotos);
  for (size_t k = 0; k < sampled; ++k) {
    input.photos.push_back(
        context.input.photos[(2 * k + 1) * count / (2 * sampled)]);
  }
  SfmOptions options = context.options;
  options.max_image_size = kSmallest;
  options.max_features = 100000;
  const StepContext probe{input, options, context.colmap, context.num_threads};

  const fs::path path = context.input.work_folder / "image_size.db";
  RemoveDatabase(path);
  FREEGS_RETURN_IF_ERROR(ExtractFeatures(probe, path, context.num_threads));
  std::vector<int64_t> counts;
  {
    FREEGS_ASSIGN_OR_RETURN(const MatchDatabase database,
                            MatchDatabase::Open(path));
    FREEGS_ASSIGN_OR_RETURN(const auto photos, database.Photos());
    for (const auto& photo : photos) counts.push_back(photo.num_features);
  }
  RemoveDatabase(path);
  return counts;
}

}  // namespace

StatusOr<int> ChooseImageSize(const StepContext& context) {
  int longest = 0;
  for (const SfmPhoto& photo : context.input.photos) {
    longest = std::max({longest, photo.width, photo.height});
  }
  if (longest <= kSmallest) return kLargest;
  FREEGS_ASSIGN_OR_RETURN(std::vector<int64_t> counts, CountFeatures(context));
  if (counts.empty()) return kLargest;
  return ImageSizeFor(UpperMedian(std::move(counts)),
                      context.options.max_features);
}

int ImageSizeFor(int64_t found, int max_features) {
  if (found <= 0) return kLargest;
  // Their number grows a little faster than the image's side.
  const double size = kSmallest * kEnough * max_features / found;
  return static_cast<int>(
      std::clamp<double>(std::ceil(size / 100) * 100, kSmallest, kLargest));
}

}  // namespace freegs::sfm
