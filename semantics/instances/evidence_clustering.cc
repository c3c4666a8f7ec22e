// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/instances/evidence_clustering.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "semantics/patches/region_merging.h"

namespace freegs::semantics {
namespace {

// Regions of a smaller share of all pixels are crumbs: they join a neighbour
// or, if they have none, belong to nobody.
constexpr double kCrumbShare = 2e-4;
// A region is background if it is this flat (RegionExtent::Flatness) and its
// width, a standard deviation, is this many scene radii.
constexpr double kBackgroundFlatness = 0.2;
constexpr double kBackgroundWidth = 0.4;

// For each region of the tree: the height at which it is joined to another.
std::vector<double> JoinHeights(const RegionTree& tree) {
  std::vector<double> heights(tree.num_leaves + tree.merges.size(),
                              std::numeric_limits<double>::infinity());
  for (const RegionTree::Merge& merge : tree.merges) {
    heights[merge.a] = merge.height;
    heights[merge.b] = merge.height;
  }
  return heights;
}

}  // namespace

Status EvidenceClusteringOptions::Check() const {
  if (!std::isfinite(granularity)) {
    return InvalidArgumentError("granularity must be a number");
  }
  return Status();
}

StatusOr<EvidenceClusters> ClusterByEvidence(
    const ScenePatches& patches,
    double scene_radius,
    const EvidenceModel& model,
    const EvidenceClusteringOptions& options) {
  FREEGS_RETURN_IF_ERROR(options.Check());
  EvidenceClusters result;
  const auto difference = [&model](const Evidence& evidence) {
    return model.Difference(evidence);
  };
  const RegionTree tree = MergeRegions(patches.graph, difference);
  const std::vector<int32_t> cut = tree.Cut(-options.granularity);
  const std::vector<int32_t> region_of_patch = AbsorbSmallRegions(
      patches.graph, cut, difference, kCrumbShare * patches.graph.total_pixels);
  // What stood against joining the regions that others were absorbed by.
  const std::vector<double> join_heights = JoinHeights(tree);
  std::vector<double> heights(region_of_patch.size(),
                              -std::numeric_limits<double>::infinity());
  for (size_t p = 0; p < cut.size(); ++p) {
    double& height = heights[region_of_patch[p]];
    height = std::max(height, join_heights[cut[p]]);
  }

  std::vector<RegionStats> regions(heights.size());
  for (size_t p = 0; p < region_of_patch.size(); ++p) {
    regions[region_of_patch[p]].Add(patches.graph.regions[p]);
  }
  std::vector<int32_t> label_of_region(heights.size(), -1);
  for (size_t r = 0; r < regions.size(); ++r) {
    if (!(regions[r].pixels > kCrumbShare * patches.graph.total_pixels)) {
      continue;
    }
    label_of_region[r] = static_cast<int32_t>(result.scores.size());
    result.scores.push_back(1 / (1 + std::exp(-heights[r])));
    const RegionExtent extent =
        ExtentOf(regions[r].weight, regions[r].position, regions[r].position2);
    const bool background = extent.Flatness() <= kBackgroundFlatness &&
                            extent.width >= kBackgroundWidth * scene_radius;
    result.is_plane.push_back(background);
    if (background) {
      result.planes.push_back(
          {extent.normal, extent.normal.dot(extent.centre)});
    }
  }
  result.labels.assign(patches.patch_of_gaussian.size(), -1);
  for (size_t g = 0; g < result.labels.size(); ++g) {
    const int32_t patch = patches.patch_of_gaussian[g];
    if (patch >= 0) {
      result.labels[g] = label_of_region[region_of_patch[patch]];
    }
  }
  return result;
}

}  // namespace freegs::semantics
