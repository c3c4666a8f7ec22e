// SPDX-License-Identifier: BSD-3-Clause

#include "sfm/features/point_colors.h"

#include <array>
#include <unordered_map>
#include <vector>

#include "core/cancellation.h"
#include "core/io/image_io.h"
#include "core/parallel.h"
#include "sfm/features/sift.h"

namespace freegs::sfm {
namespace {

using PointIndex = std::unordered_map<uint64_t, size_t>;

struct ColorSum {
  std::array<uint64_t, 3> rgb = {};
  uint64_t count = 0;
};

// Adds the colours that an image shows to the sums of its points.
Status AddColors(const SfmInput& input,
                 const PosedImage& image,
                 const PointIndex& points,
                 std::vector<ColorSum>* sums) {
  if (IsCancelled(input.cancellation)) {
    return InterruptedError("stopped on request");
  }
  FREEGS_ASSIGN_OR_RETURN(const ImageU8 photo,
                          ReadRgb(input.photo_folder / image.name));
  for (const Point2D& feature : image.points2d) {
    const auto point = points.find(feature.point3d_id);
    const Eigen::Vector2d& xy = feature.xy;
    if (point == points.end() || !(xy.x() >= 0 && xy.x() < photo.width()) ||
        !(xy.y() >= 0 && xy.y() < photo.height())) {
      continue;
    }
    ColorSum& sum = (*sums)[point->second];
    for (int c = 0; c < 3; ++c) {
      sum.rgb[c] +=
          photo(static_cast<int>(xy.x()), static_cast<int>(xy.y()), c);
    }
    ++sum.count;
  }
  return {};
}

}  // namespace

Status ColorPoints(const SfmInput& input,
                   int num_threads,
                   Reconstruction* model) {
  const PointIndex points = IndexPoints(*model);
  const OneOpenCvThread one;
  ThreadPool pool(num_threads);
  // Sums of whole numbers are the same in any order.
  std::vector<std::vector<ColorSum>> sums(
      pool.num_threads(), std::vector<ColorSum>(model->points3d.size()));
  std::vector<Status> ended(model->images.size());
  const auto count = static_cast<int64_t>(model->images.size());
  pool.ParallelFor(0, count, 1, [&](int64_t i, int64_t, int thread) {
    ended[i] = AddColors(input, model->images[i], points, &sums[thread]);
  });
  for (const Status& status : ended) FREEGS_RETURN_IF_ERROR(status);
  for (size_t i = 0; i < model->points3d.size(); ++i) {
    ColorSum all;
    for (const std::vector<ColorSum>& part : sums) {
      for (int c = 0; c < 3; ++c) all.rgb[c] += part[i].rgb[c];
      all.count += part[i].count;
    }
    if (all.count == 0) continue;
    for (int c = 0; c < 3; ++c) {
      model->points3d[i].rgb[c] =
          static_cast<uint8_t>((all.rgb[c] + all.count / 2) / all.count);
    }
  }
  return {};
}

}  // namespace freegs::sfm
