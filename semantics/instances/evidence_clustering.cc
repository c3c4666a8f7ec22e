// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/instances/evidence_clustering.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "semantics/instances/label_noise.h"
#include "semantics/patches/evidence.h"
#include "semantics/patches/region_graph.h"
#include "semantics/patches/region_merging.h"
#include "semantics/patches/shared_pixels.h"
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

// A tree of a division's patches.
struct JudgedTree {
  RegionTree tree;
  std::vector<double> quality;    // Of each region.
  std::vector<uint8_t> is_large;  // Whether it is no crumb.
};

JudgedTree BuildTree(const RegionGraph& graph,
                     std::span<const Evidence> of_contacts,
                     int variant,
                     const LearntModels& models) {
  const double crumb_size = CrumbSize(graph.total_pixels);
  MeasuredTree measured = MergeAndMeasure(
      graph, of_contacts, VariantOf(models.evidence, variant), crumb_size);
  JudgedTree result;
  for (const RegionAttributes& attributes : measured.attributes) {
    result.quality.push_back(models.quality.Probability(attributes));
  }
  for (const double pixels : measured.tree.Sums(graph.PixelsOfRegions())) {
    result.is_large.push_back(pixels >= crumb_size ? 1 : 0);
  }
  result.tree = std::move(measured.tree);
  return result;
}

// How good the trees of a division find each region of another tree: the sum
// over the trees.
std::vector<double> QualityInTrees(const JudgedTree& tree,
                                   std::span<const JudgedTree> others,
                                   std::span<const SharedPixels> shared) {
  std::vector<double> sum(tree.quality.size(), 0.0);
  for (const JudgedTree& other : others) {
    const std::vector<double> quality = QualityInOther(tree.tree,
                                                       tree.is_large,
                                                       other.tree,
                                                       other.is_large,
                                                       other.quality,
                                                       shared);
    for (size_t r = 0; r < sum.size(); ++r) sum[r] += quality[r];
  }
  return sum;
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

std::vector<Hierarchy> BuildHierarchies(std::span<const ScenePatches> divisions,
                                        const LearntModels& models,
                                        ThreadPool& pool) {
  const auto num_divisions = static_cast<int64_t>(divisions.size());
  const auto num_trees = num_divisions * kNumTreeVariants;
  std::vector<std::vector<Evidence>> of_contacts(divisions.size());
  pool.ParallelFor(0, num_divisions, 1, [&](int64_t first, int64_t last, int) {
    for (int64_t d = first; d < last; ++d) {
      of_contacts[d] = EvidenceOfContacts(divisions[d].graph);
    }
  });
  std::vector<JudgedTree> trees(num_trees);
  pool.ParallelFor(0, num_trees, 1, [&](int64_t first, int64_t last, int) {
    for (int64_t t = first; t < last; ++t) {
      trees[t] = BuildTree(divisions[t / kNumTreeVariants].graph,
                           of_contacts[t / kNumTreeVariants],
                           static_cast<int>(t % kNumTreeVariants),
                           models);
    }
  });
  // How good the trees of each division find the first tree of each.
  std::vector<std::vector<double>> quality(num_divisions * num_divisions);
  pool.ParallelFor(0,
                   num_divisions * num_divisions,
                   1,
                   [&](int64_t first, int64_t last, int) {
                     for (int64_t pair = first; pair < last; ++pair) {
                       const int64_t own = pair / num_divisions;
                       const int64_t other = pair % num_divisions;
                       quality[pair] = QualityInTrees(
                           trees[own * kNumTreeVariants],
                           std::span(trees).subspan(other * kNumTreeVariants,
                                                    kNumTreeVariants),
                           FindSharedPixels(divisions[own].patch_of_gaussian,
                                            divisions[other].patch_of_gaussian,
                                            divisions[own].seen));
                     }
                   });
  std::vector<Hierarchy> hierarchies;
  for (int64_t own = 0; own < num_divisions; ++own) {
    const ScenePatches& patches = divisions[own];
    JudgedTree& tree = trees[own * kNumTreeVariants];
    Hierarchy& hierarchy = hierarchies.emplace_back();
    hierarchy.total_pixels = patches.graph.total_pixels;
    hierarchy.part_pixels = patches.graph.PixelsOfRegions();
    hierarchy.part_of_gaussian = patches.patch_of_gaussian;
    for (size_t r = 0; r < tree.quality.size(); ++r) {
      double sum = 0;
      for (int64_t other = 0; other < num_divisions; ++other) {
        sum += quality[own * num_divisions + other][r];
      }
      hierarchy.quality.push_back(
          RoundedQuality(sum / static_cast<double>(num_trees)));
    }
    hierarchy.tree = std::move(tree.tree);
  }
  return hierarchies;
}

DivisionChoice DivisionMostAgreedOn(std::span<const Hierarchy> hierarchies,
                                    std::span<const double> seen,
                                    ThreadPool& pool) {
  std::vector<std::vector<int32_t>> labels(hierarchies.size());
  std::vector<double> agreement(hierarchies.size(), 0.0);
  const auto num_divisions = static_cast<int64_t>(hierarchies.size());
  pool.ParallelFor(0, num_divisions, 1, [&](int64_t first, int64_t last, int) {
    for (int64_t d = first; d < last; ++d) {
      labels[d] = CutHierarchy(hierarchies[d], 0).label_of_gaussian;
    }
  });
  pool.ParallelFor(0, num_divisions, 1, [&](int64_t first, int64_t last, int) {
    for (int64_t d = first; d < last; ++d) {
      for (size_t other = 0; other < labels.size(); ++other) {
        if (other == static_cast<size_t>(d)) continue;
        agreement[d] += Agreement(labels[d], labels[other], seen);
      }
    }
  });
  const auto most = std::ranges::max_element(agreement);
  const auto others = static_cast<double>(hierarchies.size()) - 1;
  return {static_cast<size_t>(most - agreement.begin()),
          others > 0 ? *most / others : 0};
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
    std::span<const ScenePatches> divisions,
    double scene_radius,
    double haze_distance,
    const LearntModels& models,
    const EvidenceClusteringOptions& options,
    ThreadPool& pool) {
  FREEGS_RETURN_IF_ERROR(options.Check());
  std::vector<Hierarchy> hierarchies =
      BuildHierarchies(divisions, models, pool);
  const DivisionChoice chosen =
      DivisionMostAgreedOn(hierarchies, divisions[0].seen, pool);
  Hierarchy hierarchy = std::move(hierarchies[chosen.division]);
  hierarchy.granularity = options.granularity;
  DropLonelyCrumbs(&hierarchy);
  for (int round = 0; round < kHazeRounds; ++round) {
    LabelNoise(model, haze_distance, pool, &hierarchy.part_of_gaussian);
  }
  EvidenceClusters clusters = CutIntoClusters(
      std::move(hierarchy), divisions[chosen.division], scene_radius);
  clusters.division = chosen.division;
  clusters.agreement = chosen.agreement;
  return clusters;
}

}  // namespace freegs::semantics
