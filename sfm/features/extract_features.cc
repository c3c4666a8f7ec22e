// SPDX-License-Identifier: BSD-3-Clause

#include "sfm/features/extract_features.h"

#include <algorithm>
#include <vector>

#include "core/cancellation.h"
#include "core/parallel.h"
#include "sfm/features/sift.h"
#include "sfm/matching/match_database.h"

namespace freegs::sfm {
namespace {

namespace fs = std::filesystem;

// Photos whose features are written together. A run that is killed finds only
// these again.
constexpr size_t kBatch = 16;

StatusOr<SiftFeatures> FeaturesOf(const StepContext& context,
                                  const std::string& name) {
  if (IsCancelled(context.input.cancellation)) {
    return InterruptedError("stopped on request");
  }
  return FindPhotoSift(context.input.photo_folder / name,
                       context.input.MaskOf(name),
                       context.options.max_image_size,
                       context.options.max_features);
}

}  // namespace

Status ExtractFeatures(const StepContext& context,
                       const fs::path& database_path) {
  FREEGS_ASSIGN_OR_RETURN(MatchDatabase database,
                          MatchDatabase::Open(database_path));
  FREEGS_ASSIGN_OR_RETURN(std::vector<MatchDatabase::Photo> photos,
                          database.Photos());
  const size_t total = photos.size();
  std::erase_if(photos,
                [](const auto& photo) { return photo.num_features > 0; });
  const auto report = [&](size_t left) {
    context.Report("features",
                   static_cast<double>(total - left),
                   static_cast<double>(total),
                   "");
  };
  report(photos.size());
  const OneOpenCvThread one;
  ThreadPool pool(context.num_threads);
  for (size_t first = 0; first < photos.size(); first += kBatch) {
    const size_t count = std::min(kBatch, photos.size() - first);
    std::vector<StatusOr<SiftFeatures>> found(
        count, StatusOr<SiftFeatures>(SiftFeatures()));
    pool.ParallelFor(0, count, 1, [&](int64_t begin, int64_t, int) {
      found[begin] = FeaturesOf(context, photos[first + begin].name);
    });
    std::vector<PhotoKeypoints> rows;
    for (size_t i = 0; i < count; ++i) {
      FREEGS_RETURN_IF_ERROR(found[i].status());
      rows.push_back(
          {photos[first + i].id, &found[i]->keypoints, &found[i]->descriptors});
    }
    FREEGS_RETURN_IF_ERROR(database.AddFeatures(rows));
    report(photos.size() - first - count);
  }
  return {};
}

}  // namespace freegs::sfm
