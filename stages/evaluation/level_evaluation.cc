// SPDX-License-Identifier: BSD-3-Clause

#include "stages/evaluation/level_evaluation.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <utility>
#include <vector>

#include "semantics/metrics/instance_metrics.h"
#include "stages/evaluation/instance_evaluation.h"

namespace freegs::stages {
namespace {

// Regions of each object whose masks are rendered. The counts of pixels that
// they are chosen by are of the smallest parts, which differ a little from
// those of whole regions: a pixel on an outline may show more of another part
// than of any single part of the region.
constexpr size_t kRenderedRegions = 2;

// The pixels of an object, and those that each answer has and shares with it.
struct RegionOverlap {
  double truth = 0;
  std::vector<double> size;
  std::vector<double> shared;

  double Iou(size_t answer) const {
    const double all = truth + size[answer] - shared[answer];
    return all > 0 ? shared[answer] / all : 0;
  }

  void Add(const RegionOverlap& other) {
    truth += other.truth;
    for (size_t k = 0; k < size.size(); ++k) {
      size[k] += other.size[k];
      shared[k] += other.shared[k];
    }
  }
};

// Over all views together, how each object overlaps with each region.
StatusOr<std::map<int, RegionOverlap>> OverlapsOfRegions(
    const EvaluationContext& context, const semantics::Hierarchy& hierarchy) {
  const semantics::RegionTree& tree = hierarchy.tree;
  std::map<int, RegionOverlap> overlaps;
  const auto add_view = [&](const JudgedView& view) -> Status {
    for (const ImageU16& layer : view.truth) {
      FREEGS_ASSIGN_OR_RETURN(const semantics::InstanceOverlap overlap,
                              semantics::CountOverlap(layer, view.rendered));
      std::vector<double> size(tree.num_leaves, 0.0);
      for (const auto& [part, pixels] : overlap.instance_pixels) {
        size[part] = static_cast<double>(pixels);
      }
      size = tree.Sums(size);
      for (const auto& [object, pixels] : overlap.truth_pixels) {
        if (pixels < kMinMaskPixels) continue;
        std::vector<double> shared(tree.num_leaves, 0.0);
        for (auto it = overlap.shared_pixels.lower_bound({object, 0});
             it != overlap.shared_pixels.end() && it->first.first == object;
             ++it) {
          shared[it->first.second] = static_cast<double>(it->second);
        }
        const RegionOverlap in_view{
            static_cast<double>(pixels), size, tree.Sums(shared)};
        const auto [it, is_new] = overlaps.try_emplace(object, in_view);
        if (!is_new) it->second.Add(in_view);
      }
    }
    return Status();
  };
  FREEGS_RETURN_IF_ERROR(
      context.ForEachView(hierarchy.part_of_gaussian, add_view));
  return overlaps;
}

std::vector<int32_t> BestRegions(const RegionOverlap& overlap) {
  std::vector<int32_t> regions(overlap.size.size());
  std::iota(regions.begin(), regions.end(), 0);
  const size_t count = std::min(regions.size(), kRenderedRegions);
  std::partial_sort(regions.begin(),
                    regions.begin() + static_cast<std::ptrdiff_t>(count),
                    regions.end(),
                    [&overlap](int32_t a, int32_t b) {
                      return std::pair(-overlap.Iou(a), a) <
                             std::pair(-overlap.Iou(b), b);
                    });
  regions.resize(count);
  return regions;
}

// How an object and one answer overlap, view by view and in all of them.
struct Answer {
  std::vector<double> ious;
  RegionOverlap sum{0, {0}, {0}};
};

// Adds what one view shows, if it shows enough of the object.
void AddView(const semantics::InstanceOverlap& overlap,
             int object,
             int32_t label,
             Answer* answer) {
  const auto truth = overlap.truth_pixels.find(object);
  if (truth == overlap.truth_pixels.end() || truth->second < kMinMaskPixels) {
    return;
  }
  const auto size = overlap.instance_pixels.find(label);
  const auto shared = overlap.shared_pixels.find({object, label});
  const RegionOverlap in_view{static_cast<double>(truth->second),
                              {size == overlap.instance_pixels.end()
                                   ? 0
                                   : static_cast<double>(size->second)},
                              {shared == overlap.shared_pixels.end()
                                   ? 0
                                   : static_cast<double>(shared->second)}};
  answer->ious.push_back(in_view.Iou(0));
  answer->sum.Add(in_view);
}

// The region of the hierarchy, in front of all instances.
StatusOr<Answer> AnswerOf(const EvaluationContext& context,
                          std::span<const int32_t> instance_of_gaussian,
                          const semantics::Hierarchy& hierarchy,
                          int object,
                          int32_t region) {
  std::vector<int32_t> labels(instance_of_gaussian.begin(),
                              instance_of_gaussian.end());
  const int32_t label =
      labels.empty() ? 0 : *std::max_element(labels.begin(), labels.end()) + 1;
  const std::vector<uint8_t> inside = semantics::GaussiansOf(hierarchy, region);
  for (size_t g = 0; g < labels.size(); ++g) {
    if (inside[g] != 0) labels[g] = label;
  }
  Answer answer;
  const auto add_view = [&](const JudgedView& view) -> Status {
    for (const ImageU16& layer : view.truth) {
      FREEGS_ASSIGN_OR_RETURN(const semantics::InstanceOverlap overlap,
                              semantics::CountOverlap(layer, view.rendered));
      AddView(overlap, object, label, &answer);
    }
    return Status();
  };
  FREEGS_RETURN_IF_ERROR(context.ForEachView(labels, add_view));
  return answer;
}

// For each object the instance of the highest IoU over all views together.
StatusOr<std::map<int, Answer>> BestInstances(
    const EvaluationContext& context,
    std::span<const int32_t> instance_of_gaussian) {
  std::vector<semantics::InstanceOverlap> overlaps;
  semantics::InstanceOverlap sum;
  const auto add_view = [&](const JudgedView& view) -> Status {
    for (const ImageU16& layer : view.truth) {
      FREEGS_ASSIGN_OR_RETURN(semantics::InstanceOverlap overlap,
                              semantics::CountOverlap(layer, view.rendered));
      overlaps.push_back(overlap);
      // Every layer counts the pixels of all instances; they must enter the
      // sum only once.
      if (&layer != &view.truth.front()) overlap.instance_pixels.clear();
      sum.Add(overlap);
    }
    return Status();
  };
  FREEGS_RETURN_IF_ERROR(context.ForEachView(instance_of_gaussian, add_view));
  std::map<int, Answer> answers;
  for (const auto& [object, pixels] : sum.truth_pixels) {
    const auto match = semantics::BestMatch(sum, object);
    for (const semantics::InstanceOverlap& overlap : overlaps) {
      AddView(overlap, object, match ? match->instance : -1, &answers[object]);
    }
  }
  return answers;
}

}  // namespace

StatusOr<std::optional<double>> MeasureBestLevels(
    const EvaluationContext& context,
    std::span<const int32_t> instance_of_gaussian,
    const semantics::Hierarchy& hierarchy) {
  FREEGS_ASSIGN_OR_RETURN(const auto overlaps,
                          OverlapsOfRegions(context, hierarchy));
  FREEGS_ASSIGN_OR_RETURN(auto answers,
                          BestInstances(context, instance_of_gaussian));
  std::vector<double> ious;
  for (auto& [object, best] : answers) {
    const auto overlap = overlaps.find(object);
    if (overlap == overlaps.end()) continue;  // Too small in every view.
    for (const int32_t region : BestRegions(overlap->second)) {
      FREEGS_ASSIGN_OR_RETURN(
          Answer answer,
          AnswerOf(context, instance_of_gaussian, hierarchy, object, region));
      if (answer.sum.Iou(0) > best.sum.Iou(0)) best = std::move(answer);
    }
    ious.insert(ious.end(), best.ious.begin(), best.ious.end());
  }
  return MeanOrNothing(ious);
}

}  // namespace freegs::stages
