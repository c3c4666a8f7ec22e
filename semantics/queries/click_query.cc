// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/queries/click_query.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "splat/weights/pixel_weights.h"

namespace freegs::semantics {
namespace {

// A pixel where the instances' weights sum to less has no instance, as in
// splat::RenderLabels.
constexpr float kMinWeight = 0.5f;
// Share of an instance's pixels that may lie outside the box around it on each
// side, so that stray pixels do not count.
constexpr double kTrim = 0.01;

// What one label gives to a pixel.
struct LabelVote {
  float weight = 0;
  double weighted_depth = 0;
};

// The interval that holds all but a share kTrim of the counts on each side.
struct Interval {
  double begin = 0;
  double end = 0;
  double length() const { return end - begin; }
};

Interval TrimmedInterval(std::span<const int64_t> counts) {
  int64_t total = 0;
  for (const int64_t count : counts) total += count;
  const auto spare =
      static_cast<int64_t>(std::floor(kTrim * static_cast<double>(total)));
  size_t first = 0;
  for (int64_t left = spare; first + 1 < counts.size(); ++first) {
    left -= counts[first];
    if (left < 0) break;
  }
  size_t last = counts.size() - 1;
  for (int64_t left = spare; last > first; --last) {
    left -= counts[last];
    if (left < 0) break;
  }
  return {static_cast<double>(first), static_cast<double>(last + 1)};
}

double Overlap(const Interval& a, const Interval& b) {
  return std::max(0.0, std::min(a.end, b.end) - std::max(a.begin, b.begin));
}

// Pixels of one label by column and by row.
struct LabelExtent {
  std::vector<int64_t> columns;
  std::vector<int64_t> rows;
};

// What is left of the drawn box in the image, by axis.
Interval Cut(double a, double b, int size) {
  return {std::clamp(std::min(a, b), 0.0, static_cast<double>(size)),
          std::clamp(std::max(a, b), 0.0, static_cast<double>(size))};
}

}  // namespace

StatusOr<std::vector<ClickHit>> QueryClick(const splat::GaussianModel& model,
                                           std::span<const int32_t> labels,
                                           const View& view,
                                           const splat::RenderOptions& render,
                                           const Pixel& pixel,
                                           ThreadPool& pool) {
  if (labels.size() != model.size()) {
    return InvalidArgumentError(std::to_string(labels.size()) + " labels for " +
                                std::to_string(model.size()) + " Gaussians");
  }
  FREEGS_ASSIGN_OR_RETURN(const std::vector<splat::PixelWeight> weights,
                          splat::ComputePixelWeights(model,
                                                     view.camera,
                                                     view.cam_from_world,
                                                     render,
                                                     pixel.x,
                                                     pixel.y,
                                                     pool));
  std::map<int32_t, LabelVote> votes;
  float total = 0;
  for (const splat::PixelWeight& entry : weights) {
    const int32_t label = labels[entry.gaussian];
    if (label < 0) continue;
    LabelVote& vote = votes[label];
    vote.weight += entry.weight;
    vote.weighted_depth += static_cast<double>(entry.weight) * entry.depth;
    total += entry.weight;
  }
  std::vector<ClickHit> hits;
  if (total < kMinWeight) return hits;

  const Pinhole& camera = view.camera;
  const Eigen::Vector3d ray((pixel.x + 0.5 - camera.cx) / camera.fx,
                            (pixel.y + 0.5 - camera.cy) / camera.fy,
                            1);
  const Rigid3d world_from_cam = Inverse(view.cam_from_world);
  for (const auto& [label, vote] : votes) {
    const double depth = vote.weighted_depth / vote.weight;
    hits.push_back({label + 1, vote.weight, world_from_cam * (depth * ray)});
  }
  std::stable_sort(
      hits.begin(), hits.end(), [](const ClickHit& a, const ClickHit& b) {
        return a.weight > b.weight;
      });
  return hits;
}

StatusOr<std::vector<BoxHit>> QueryBox(const Image<int32_t>& label_image,
                                       const PixelBox& box,
                                       const BoxQueryOptions& options,
                                       std::span<const uint8_t> is_background) {
  const int width = label_image.width();
  const int height = label_image.height();
  const Interval box_x = Cut(box.x0, box.x1, width);
  const Interval box_y = Cut(box.y0, box.y1, height);
  // The sum is not finite if one of the numbers is not.
  const bool finite = std::isfinite(box.x0 + box.x1 + box.y0 + box.y1);
  if (!finite || !(box_x.length() > 0) || !(box_y.length() > 0)) {
    return InvalidArgumentError("the box has no area in an image of " +
                                std::to_string(width) + " x " +
                                std::to_string(height));
  }
  const auto background = [&](int32_t label) {
    return static_cast<size_t>(label) < is_background.size() &&
           is_background[static_cast<size_t>(label)] != 0;
  };
  std::map<int32_t, LabelExtent> extents;
  for (int y = static_cast<int>(box_y.begin); y < std::ceil(box_y.end); ++y) {
    for (int x = static_cast<int>(box_x.begin); x < std::ceil(box_x.end); ++x) {
      const int32_t label = label_image(x, y);
      if (label < 0 || (background(label) && !options.background)) continue;
      extents[label];
    }
  }
  for (auto& [label, extent] : extents) {
    extent.columns.resize(static_cast<size_t>(width));
    extent.rows.resize(static_cast<size_t>(height));
  }
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const auto found = extents.find(label_image(x, y));
      if (found == extents.end()) continue;
      ++found->second.columns[static_cast<size_t>(x)];
      ++found->second.rows[static_cast<size_t>(y)];
    }
  }
  std::vector<BoxHit> hits;
  for (const auto& [label, extent] : extents) {
    const Interval x = TrimmedInterval(extent.columns);
    const Interval y = TrimmedInterval(extent.rows);
    const double both = Overlap(x, box_x) * Overlap(y, box_y);
    const double either =
        x.length() * y.length() + box_x.length() * box_y.length() - both;
    hits.push_back({label + 1, both / either});
  }
  std::stable_sort(
      hits.begin(), hits.end(), [](const BoxHit& a, const BoxHit& b) {
        return a.iou > b.iou;
      });
  return hits;
}

}  // namespace freegs::semantics
