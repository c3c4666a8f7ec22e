// SPDX-License-Identifier: BSD-3-Clause

#include "sfm/features/image_size.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/parallel.h"
#include "core/quantile.h"
#include "sfm/features/sift.h"

namespace freegs::sfm {
namespace {

constexpr int kSamplePhotos = 4;
constexpr int kSmallest = 800;
constexpr int kLargest = 1600;
constexpr int kAllFeatures = 1 << 30;

// Features that are enough in an image, as a share of max_features: the last of
// them are the finest, which cost most and are found again least.
constexpr double kEnough = 0.8;

// The number of features of a few of the photos, evenly chosen, at the smallest
// size.
StatusOr<std::vector<int64_t>> CountFeatures(const StepContext& context) {
  const size_t photos = context.input.photos.size();
  const size_t sampled = std::min<size_t>(photos, kSamplePhotos);
  std::vector<int64_t> counts(sampled, 0);
  std::vector<Status> ended(sampled);
  const OneOpenCvThread one;
  ThreadPool pool(context.num_threads);
  pool.ParallelFor(0, sampled, 1, [&](int64_t k, int64_t, int) {
    const SfmPhoto& photo =
        context.input.photos[(2 * k + 1) * photos / (2 * sampled)];
    const auto features = FindPhotoSift(context.input.photo_folder / photo.name,
                                        context.input.MaskOf(photo.name),
                                        kSmallest,
                                        kAllFeatures);
    ended[k] = features.status();
    if (features.ok()) {
      counts[k] = static_cast<int64_t>(features->keypoints.size());
    }
  });
  for (const Status& status : ended) FREEGS_RETURN_IF_ERROR(status);
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
