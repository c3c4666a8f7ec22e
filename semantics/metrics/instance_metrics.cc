// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/metrics/instance_metrics.h"

#include <limits>

#include <opencv2/imgproc.hpp>

namespace freegs::semantics {
namespace {

template <typename Map, typename Key>
int64_t CountOf(const Map& map, const Key& key) {
  const auto found = map.find(key);
  return found == map.end() ? 0 : found->second;
}

}  // namespace

void InstanceOverlap::Add(const InstanceOverlap& other) {
  for (const auto& [id, count] : other.truth_pixels) truth_pixels[id] += count;
  for (const auto& [id, count] : other.instance_pixels) {
    instance_pixels[id] += count;
  }
  for (const auto& [pair, count] : other.shared_pixels) {
    shared_pixels[pair] += count;
  }
}

double InstanceOverlap::Iou(int object, int instance) const {
  const int64_t shared = CountOf(shared_pixels, std::pair(object, instance));
  const int64_t all = CountOf(truth_pixels, object) +
                      CountOf(instance_pixels, instance) - shared;
  return all > 0 ? static_cast<double>(shared) / static_cast<double>(all) : 0;
}

StatusOr<InstanceOverlap> CountOverlap(const ImageU16& truth,
                                       const Image<int32_t>& instances) {
  if (truth.width() != instances.width() ||
      truth.height() != instances.height()) {
    return InvalidArgumentError("masks and instances differ in size");
  }
  InstanceOverlap overlap;
  for (size_t i = 0; i < truth.num_pixels(); ++i) {
    const int object = truth.data()[i];
    const int instance = instances.data()[i];
    if (object > 0) ++overlap.truth_pixels[object];
    if (instance >= 0) ++overlap.instance_pixels[instance];
    if (object > 0 && instance >= 0) {
      ++overlap.shared_pixels[{object, instance}];
    }
  }
  return overlap;
}

std::optional<InstanceMatch> BestMatch(const InstanceOverlap& overlap,
                                       int object) {
  std::optional<InstanceMatch> best;
  auto it = overlap.shared_pixels.lower_bound(
      {object, std::numeric_limits<int>::min()});
  for (; it != overlap.shared_pixels.end() && it->first.first == object; ++it) {
    const double iou = overlap.Iou(object, it->first.second);
    if (!best || iou > best->iou) best = {it->first.second, iou};
  }
  return best;
}

std::optional<Eigen::Vector2i> ClickPoint(const ImageU16& truth, int id) {
  // A ring of background stands for the outside of the image.
  cv::Mat mask = cv::Mat::zeros(truth.height() + 2, truth.width() + 2, CV_8UC1);
  bool found = false;
  for (int y = 0; y < truth.height(); ++y) {
    for (int x = 0; x < truth.width(); ++x) {
      if (truth(x, y) != id) continue;
      mask.at<uint8_t>(y + 1, x + 1) = 255;
      found = true;
    }
  }
  if (!found) return std::nullopt;
  cv::Mat distance;
  cv::distanceTransform(mask, distance, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  cv::Point deepest;
  cv::minMaxLoc(distance, nullptr, nullptr, nullptr, &deepest);
  return Eigen::Vector2i(deepest.x - 1, deepest.y - 1);
}

StatusOr<double> MaskIou(const ImageU8& a, const ImageU8& b) {
  if (a.width() != b.width() || a.height() != b.height() || a.channels() != 1 ||
      b.channels() != 1) {
    return InvalidArgumentError("masks of different size");
  }
  int64_t both = 0;
  int64_t either = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    const bool in_a = a.data()[i] != 0;
    const bool in_b = b.data()[i] != 0;
    both += in_a && in_b ? 1 : 0;
    either += in_a || in_b ? 1 : 0;
  }
  return either > 0 ? static_cast<double>(both) / static_cast<double>(either)
                    : 0.0;
}

}  // namespace freegs::semantics
