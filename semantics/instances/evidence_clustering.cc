// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/instances/evidence_clustering.h"

#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "semantics/instances/label_noise.h"
#include "semantics/patches/region_merging.h"
#include "semantics/patches/tree_variants.h"

namespace freegs::semantics {
namespace {

// A region is background if it is this flat (RegionExtent::Flatness) and its
// width, a standard deviation, is this many scene radii.
constexpr double kBackgroundFlatness = 0.2;
constexpr double kBackgroundWidth = 0.4;

// Gaussians without a part take that of the nearest one that has a part. In the
// second round, those that took one in the first round have one, too.
constexpr int kHazeRounds = 2;

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

StatusOr<LearntModels> DefaultModels() {
  LearntModels models;
  FREEGS_ASSIGN_OR_RETURN(models.evidence, DefaultEvidenceModel());
  FREEGS_ASSIGN_OR_RETURN(models.quality, DefaultQualityModel());
  return models;
}

Hierarchy BuildHierarchy(const RegionGraph& graph,
                         const LearntModels& models,
                         ThreadPool& pool) {
  Hierarchy hierarchy;
  hierarchy.total_pixels = graph.total_pixels;
  hierarchy.part_pixels = graph.PixelsOfRegions();
  const double crumb_size = CrumbSize(graph.total_pixels);
  struct Variant {
    RegionTree tree;
    std::vector<double> quality;
    std::vector<double> quality_of_first;  // For the regions of variant 0.
  };
  std::vector<Variant> variants(kNumTreeVariants);
  const std::vector<Evidence> of_contacts = EvidenceOfContacts(graph);
  pool.ParallelFor(
      0, kNumTreeVariants, 1, [&](int64_t first, int64_t last, int) {
        for (int64_t v = first; v < last; ++v) {
          MeasuredTree measured =
              MergeAndMeasure(graph,
                              of_contacts,
                              VariantOf(models.evidence, static_cast<int>(v)),
                              crumb_size);
          variants[v].tree = std::move(measured.tree);
          for (const RegionAttributes& attributes : measured.attributes) {
            variants[v].quality.push_back(
                models.quality.Probability(attributes));
          }
        }
      });
  pool.ParallelFor(
      1, kNumTreeVariants, 1, [&](int64_t first, int64_t last, int) {
        for (int64_t v = first; v < last; ++v) {
          variants[v].quality_of_first = QualityInVariant(variants[0].tree,
                                                          variants[v].tree,
                                                          variants[v].quality,
                                                          hierarchy.part_pixels,
                                                          crumb_size);
        }
      });
  hierarchy.quality = std::move(variants[0].quality);
  for (size_t r = 0; r < hierarchy.quality.size(); ++r) {
    double sum = hierarchy.quality[r];
    for (int v = 1; v < kNumTreeVariants; ++v) {
      sum += variants[v].quality_of_first[r];
    }
    hierarchy.quality[r] = RoundedQuality(sum / kNumTreeVariants);
  }
  hierarchy.tree = std::move(variants[0].tree);
  return hierarchy;
}

EvidenceClusters CutIntoClusters(Hierarchy hierarchy,
                                 const ScenePatches& patches,
                                 double scene_radius) {
  EvidenceClusters result;
  HierarchyCut cut = CutHierarchy(hierarchy, hierarchy.granularity);
  result.labels = std::move(cut.label_of_gaussian);
  for (size_t g = 0; g < result.labels.size(); ++g) {
    const int32_t own = patches.patch_of_gaussian[g];
    if (own >= 0 && own == hierarchy.part_of_gaussian[g] &&
        result.labels[g] >= 0) {
      ++result.num_clustered;
    }
  }

  std::map<int32_t, RegionStats> regions;
  for (size_t p = 0; p < cut.region_of_part.size(); ++p) {
    regions[cut.region_of_part[p]].Add(patches.graph.regions[p]);
  }
  for (const int32_t r : cut.region_of_label) {
    result.scores.push_back(hierarchy.quality[r]);
    const RegionStats& region = regions[r];
    const RegionExtent extent = ExtentOf(region);
    const bool background = extent.Flatness() <= kBackgroundFlatness &&
                            extent.width >= kBackgroundWidth * scene_radius;
    result.is_plane.push_back(background);
    if (background) {
      result.planes.push_back(
          {extent.normal, extent.normal.dot(extent.centre)});
    }
  }
  result.hierarchy = std::move(hierarchy);
  return result;
}

StatusOr<EvidenceClusters> ClusterByEvidence(
    const splat::GaussianModel& model,
    const ScenePatches& patches,
    double scene_radius,
    double haze_distance,
    const LearntModels& models,
    const EvidenceClusteringOptions& options,
    ThreadPool& pool) {
  FREEGS_RETURN_IF_ERROR(options.Check());
  Hierarchy hierarchy = BuildHierarchy(patches.graph, models, pool);
  hierarchy.granularity = options.granularity;
  hierarchy.part_of_gaussian = patches.patch_of_gaussian;
  DropLonelyCrumbs(&hierarchy);
  for (int round = 0; round < kHazeRounds; ++round) {
    LabelNoise(model, haze_distance, pool, &hierarchy.part_of_gaussian);
  }
  return CutIntoClusters(std::move(hierarchy), patches, scene_radius);
}

}  // namespace freegs::semantics
