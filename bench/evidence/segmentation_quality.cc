// SPDX-License-Identifier: BSD-3-Clause

#include "bench/evidence/segmentation_quality.h"

#include <algorithm>

namespace freegs::evidence {
namespace {

constexpr double kMinPixels = 100;

bool IsJudged(int id, double pixels) {
  return pixels >= kMinPixels && id < kFirstSurface;
}

double Iou(double shared, double a, double b) {
  const double all = a + b - shared;
  return all > 0 ? shared / all : 0;
}

}  // namespace

std::vector<ObjectQuality> MeasureObjects(
    const LearningScene& scene, const std::vector<int32_t>& region_of_patch) {
  std::map<int32_t, double> pixels;
  std::map<int32_t, std::map<int, double>> inside;
  for (size_t p = 0; p < region_of_patch.size(); ++p) {
    if (region_of_patch[p] < 0) continue;
    pixels[region_of_patch[p]] += scene.pixels[p];
    for (const auto& [id, count] : scene.votes[p]) {
      inside[region_of_patch[p]][id] += count;
    }
  }
  std::vector<ObjectQuality> objects;
  for (const auto& [id, total] : scene.segment_pixels) {
    if (!IsJudged(id, total)) continue;
    ObjectQuality object;
    object.id = id;
    object.pixels = total;
    for (const auto& [region, segments] : inside) {
      const auto it = segments.find(id);
      if (it == segments.end()) continue;
      const double iou = Iou(it->second, pixels[region], total);
      if (iou > object.iou) {
        object.iou = iou;
        object.region = region;
      }
      object.pieces += it->second >= 0.1 * total;
    }
    if (object.region >= 0) object.in_region = inside[object.region];
    objects.push_back(std::move(object));
  }
  return objects;
}

double MeanIou(const std::vector<ObjectQuality>& objects) {
  double sum = 0;
  for (const ObjectQuality& object : objects) sum += object.iou;
  return sum / std::max<double>(1, static_cast<double>(objects.size()));
}

double MeanPieces(const std::vector<ObjectQuality>& objects) {
  double sum = 0;
  for (const ObjectQuality& object : objects) sum += object.pieces;
  return sum / std::max<double>(1, static_cast<double>(objects.size()));
}

double BestLevelIou(const LearningScene& scene,
                    const semantics::RegionTree& tree) {
  const std::vector<double> pixels = tree.Sums(scene.pixels);
  double sum = 0;
  int count = 0;
  for (const auto& [id, total] : scene.segment_pixels) {
    if (!IsJudged(id, total)) continue;
    std::vector<double> shared;
    for (const std::map<int, double>& votes : scene.votes) {
      const auto it = votes.find(id);
      shared.push_back(it == votes.end() ? 0 : it->second);
    }
    shared = tree.Sums(shared);
    double best = 0;
    for (size_t r = 0; r < shared.size(); ++r) {
      best = std::max(best, Iou(shared[r], pixels[r], total));
    }
    sum += best;
    ++count;
  }
  return count > 0 ? sum / count : 0;
}

double BestPatchesIou(const LearningScene& scene) {
  double sum = 0;
  int count = 0;
  for (const auto& [id, total] : scene.segment_pixels) {
    if (!IsJudged(id, total)) continue;
    double shared = 0;
    double pixels = 0;
    for (size_t p = 0; p < scene.votes.size(); ++p) {
      const auto it = scene.votes[p].find(id);
      if (it == scene.votes[p].end() || it->second < 0.5 * scene.pixels[p]) {
        continue;
      }
      shared += it->second;
      pixels += scene.pixels[p];
    }
    sum += Iou(shared, pixels, total);
    ++count;
  }
  return count > 0 ? sum / count : 0;
}

}  // namespace freegs::evidence
