// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/instances/evidence_clustering.h"

#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "semantics/instances/label_noise.h"
#include "semantics/patches/region_merging.h"

namespace freegs::semantics {
namespace {

// A region is background if it is this flat (RegionExtent::Flatness) and its
// width, a standard deviation, is this many scene radii.
constexpr double kBackgroundFlatness = 0.2;
constexpr double kBackgroundWidth = 0.4;

// For each region: the height at which it is joined to one that is not a crumb.
std::vector<double> JoinHeights(const Hierarchy& hierarchy) {
  const RegionTree& tree = hierarchy.tree;
  const std::vector<double> sizes = tree.Sums(hierarchy.part_pixels);
  std::vector<double> heights(sizes.size(),
                              std::numeric_limits<double>::infinity());
  for (size_t k = tree.merges.size(); k-- > 0;) {
    const RegionTree::Merge& merge = tree.merges[k];
    const double whole = heights[tree.num_leaves + k];
    heights[merge.a] = hierarchy.IsCrumb(sizes[merge.b]) ? whole : merge.height;
    heights[merge.b] = hierarchy.IsCrumb(sizes[merge.a]) ? whole : merge.height;
  }
  return heights;
}

// Gaussians of crumbs that touch nothing get no part.
void DropLonelyCrumbs(Hierarchy* hierarchy) {
  const std::vector<int32_t> whole =
      hierarchy->tree.Cut(std::numeric_limits<double>::infinity());
  const std::vector<double> sizes =
      hierarchy->tree.Sums(hierarchy->part_pixels);
  for (int32_t& part : hierarchy->part_of_gaussian) {
    if (part >= 0 && hierarchy->IsCrumb(sizes[whole[part]])) part = -1;
  }
}

}  // namespace

Status EvidenceClusteringOptions::Check() const {
  if (!std::isfinite(granularity)) {
    return InvalidArgumentError("granularity must be a number");
  }
  return Status();
}

StatusOr<EvidenceClusters> ClusterByEvidence(
    const splat::GaussianModel& model,
    const ScenePatches& patches,
    double scene_radius,
    double haze_distance,
    const EvidenceModel& evidence,
    const EvidenceClusteringOptions& options,
    ThreadPool& pool) {
  FREEGS_RETURN_IF_ERROR(options.Check());
  EvidenceClusters result;
  Hierarchy& hierarchy = result.hierarchy;
  hierarchy.tree = MergeRegions(patches.graph, [&evidence](const Evidence& e) {
    return evidence.Difference(e);
  });
  for (const RegionStats& region : patches.graph.regions) {
    hierarchy.part_pixels.push_back(region.pixels);
  }
  hierarchy.total_pixels = patches.graph.total_pixels;
  hierarchy.granularity = options.granularity;
  hierarchy.part_of_gaussian = patches.patch_of_gaussian;
  DropLonelyCrumbs(&hierarchy);
  LabelNoise(model, haze_distance, pool, &hierarchy.part_of_gaussian);
  HierarchyCut cut = CutHierarchy(hierarchy, options.granularity);
  result.labels = std::move(cut.label_of_gaussian);

  std::map<int32_t, RegionStats> regions;
  for (size_t p = 0; p < cut.region_of_part.size(); ++p) {
    regions[cut.region_of_part[p]].Add(patches.graph.regions[p]);
  }
  const std::vector<double> heights = JoinHeights(hierarchy);
  for (const int32_t r : cut.region_of_label) {
    result.scores.push_back(1 / (1 + std::exp(-heights[r])));
    const RegionStats& region = regions[r];
    const RegionExtent extent =
        ExtentOf(region.weight, region.position, region.position2);
    const bool background = extent.Flatness() <= kBackgroundFlatness &&
                            extent.width >= kBackgroundWidth * scene_radius;
    result.is_plane.push_back(background);
    if (background) {
      result.planes.push_back(
          {extent.normal, extent.normal.dot(extent.centre)});
    }
  }
  return result;
}

}  // namespace freegs::semantics
