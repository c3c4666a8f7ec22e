// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/patches/patches.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>
#include <utility>

#include "core/kd_tree.h"
#include "core/quantile.h"

namespace freegs::semantics {
namespace {

constexpr int kIterations = 4;
constexpr int kCandidates = 8;  // Patches that a point chooses from.
constexpr int64_t kGrain = 1024;
// Weight of a difference of one in colour or in the direction of the normal,
// where a distance of one patch size has weight one.
constexpr double kColorWeight = 4;
constexpr double kNormalWeight = 1;
// Cameras nearer to a point than this share of those that see it are passed
// over when its size in pixels is told.
constexpr double kNearestShare = 0.25;
// By which the grids of the next division are shifted along the first axis, in
// cells. Along the second and third axis it is twice and three times as much.
constexpr double kShift = 0.37;

// Mean position, normal, colour of a patch. Signs of normals are those of the
// patch's first point.
struct Mean {
  std::array<double, 9> sum = {};
  double count = 0;
  double size = 0;
};

std::array<double, 9> RowOf(const SurfacePoints& points, size_t i) {
  std::array<double, 9> row;
  for (size_t k = 0; k < 3; ++k) {
    row[k] = points.positions[i * 3 + k];
    row[3 + k] = points.normals[i * 3 + k];
    row[6 + k] = points.colors[i * 3 + k];
  }
  return row;
}

double SquaredDistance(const std::array<double, 9>& a,
                       const std::array<double, 9>& b,
                       double size) {
  double position = 0;
  double cosine = 0;
  double color = 0;
  for (size_t k = 0; k < 3; ++k) {
    position += (a[k] - b[k]) * (a[k] - b[k]);
    cosine += a[3 + k] * b[3 + k];
    color += (a[6 + k] - b[6 + k]) * (a[6 + k] - b[6 + k]);
  }
  return position / (size * size) +
         kNormalWeight * kNormalWeight * 2 * (1 - std::abs(cosine)) +
         kColorWeight * kColorWeight * color;
}

// The means of patches; those without points keep a count of 0.
std::vector<Mean> MeansOf(const SurfacePoints& points,
                          std::span<const float> sizes,
                          const std::vector<int32_t>& patch_of_point,
                          size_t num_patches) {
  std::vector<Mean> means(num_patches);
  for (size_t i = 0; i < patch_of_point.size(); ++i) {
    Mean& mean = means[patch_of_point[i]];
    const std::array<double, 9> row = RowOf(points, i);
    double cosine = 0;
    for (size_t k = 3; k < 6; ++k) cosine += mean.sum[k] * row[k];
    const double sign = cosine < 0 ? -1 : 1;
    for (size_t k = 0; k < 9; ++k) {
      mean.sum[k] += k >= 3 && k < 6 ? sign * row[k] : row[k];
    }
    mean.size += sizes[i];
    mean.count += 1;
  }
  for (Mean& mean : means) {
    if (mean.count == 0) continue;
    double norm2 = 0;
    for (size_t k = 3; k < 6; ++k) norm2 += mean.sum[k] * mean.sum[k];
    const double norm = norm2 > 0 ? std::sqrt(norm2) : 1;
    for (size_t k = 0; k < 9; ++k) {
      mean.sum[k] /= k >= 3 && k < 6 ? norm : mean.count;
    }
    mean.size /= mean.count;
  }
  return means;
}

// Cells of grids whose width is a power of two near the points' sizes.
std::vector<int32_t> GridCells(const SurfacePoints& points,
                               std::span<const float> sizes,
                               int division,
                               size_t* count) {
  std::map<std::array<int64_t, 4>, int32_t> cells;
  std::vector<int32_t> cell_of_point(sizes.size());
  for (size_t i = 0; i < sizes.size(); ++i) {
    const int level = std::ilogb(sizes[i]) + 1;
    std::array<int64_t, 4> key;
    key[3] = level;
    for (size_t k = 0; k < 3; ++k) {
      const double shift = kShift * division * static_cast<double>(k + 1);
      key[k] = static_cast<int64_t>(std::clamp(
          std::floor(std::ldexp(double{points.positions[i * 3 + k]}, -level) +
                     shift),
          -1e15,
          1e15));
    }
    cell_of_point[i] =
        cells.try_emplace(key, static_cast<int32_t>(cells.size()))
            .first->second;
  }
  *count = cells.size();
  return cell_of_point;
}

}  // namespace

std::vector<float> LengthOfPixels(std::span<const float> positions,
                                  std::span<const View> views,
                                  double pixels,
                                  ThreadPool& pool) {
  const size_t count = positions.size() / 3;
  std::vector<float> lengths(count, 0);
  pool.ParallelFor(
      0,
      static_cast<int64_t>(count),
      kGrain,
      [&](int64_t first, int64_t last, int) {
        std::vector<float> seen;
        for (int64_t i = first; i < last; ++i) {
          seen.clear();
          const Eigen::Vector3d x(
              positions[i * 3], positions[i * 3 + 1], positions[i * 3 + 2]);
          for (const View& view : views) {
            const Eigen::Vector3d in = view.cam_from_world * x;
            if (!(in.z() > 0)) continue;
            const Pinhole& camera = view.camera;
            const double u = camera.fx * in.x() / in.z() + camera.cx;
            const double v = camera.fy * in.y() / in.z() + camera.cy;
            if (u < 0 || v < 0 || u > camera.width || v > camera.height) {
              continue;
            }
            seen.push_back(static_cast<float>(pixels * in.z() / camera.fx));
          }
          if (seen.empty()) continue;
          lengths[i] = LowerQuantile(seen, kNearestShare);
        }
      });
  std::vector<float> known;
  for (const float length : lengths) {
    if (length > 0) known.push_back(length);
  }
  if (known.empty()) return lengths;
  const float median = UpperMedian(std::move(known));
  for (float& length : lengths) {
    if (!(length > 0)) length = median;
  }
  return lengths;
}

StatusOr<Patches> MakePatches(const SurfacePoints& points,
                              std::span<const float> sizes,
                              int division,
                              ThreadPool& pool) {
  for (const float size : sizes) {
    if (!(size > 0) || !std::isfinite(size)) {
      return InvalidArgumentError("sizes of patches must be positive");
    }
  }
  Patches patches;
  size_t num_patches = 0;
  patches.patch_of_point = GridCells(points, sizes, division, &num_patches);
  for (int iteration = 0; iteration < kIterations && num_patches > 0;
       ++iteration) {
    const std::vector<Mean> means =
        MeansOf(points, sizes, patches.patch_of_point, num_patches);
    std::vector<int32_t> alive;
    std::vector<float> centres;
    for (size_t p = 0; p < num_patches; ++p) {
      if (means[p].count == 0) continue;
      alive.push_back(static_cast<int32_t>(p));
      for (size_t k = 0; k < 3; ++k) {
        centres.push_back(static_cast<float>(means[p].sum[k]));
      }
    }
    FREEGS_ASSIGN_OR_RETURN(const KdTree tree, KdTree::Build(centres, 3));
    std::vector<int32_t> moved(patches.patch_of_point.size());
    pool.ParallelFor(0,
                     static_cast<int64_t>(moved.size()),
                     kGrain,
                     [&](int64_t first, int64_t last, int) {
                       std::vector<Neighbor> nearest;
                       for (int64_t i = first; i < last; ++i) {
                         const std::array<double, 9> row =
                             RowOf(points, static_cast<size_t>(i));
                         tree.Nearest(points.positions.data() + i * 3,
                                      kCandidates,
                                      KdTree::kNoRow,
                                      &nearest);
                         double least = std::numeric_limits<double>::infinity();
                         for (const Neighbor& neighbor : nearest) {
                           const int32_t p = alive[neighbor.index];
                           const double distance =
                               SquaredDistance(row, means[p].sum, sizes[i]);
                           if (distance < least) {
                             least = distance;
                             moved[i] = p;
                           }
                         }
                       }
                     });
    patches.patch_of_point = std::move(moved);
  }
  // Numbers without gaps.
  std::vector<int32_t> number(num_patches, -1);
  for (int32_t& patch : patches.patch_of_point) {
    if (number[patch] < 0) number[patch] = patches.count++;
    patch = number[patch];
  }
  return patches;
}

}  // namespace freegs::semantics
