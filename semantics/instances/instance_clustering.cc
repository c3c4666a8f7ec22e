// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/instances/instance_clustering.h"

#include <algorithm>
#include <map>
#include <optional>
#include <utility>

#include "semantics/instances/label_noise.h"

namespace freegs::semantics {
namespace {

// Fainter Gaussians do not tell where the scene is.
constexpr double kSceneOpacity = 0.1;
// A Gaussian without a label takes that of the nearest labelled Gaussian, if it
// is within this many scene radii.
constexpr double kNoiseDistance = 0.2;

Status Interrupted() { return InterruptedError("clustering was interrupted"); }

size_t NumWithout(const std::vector<int32_t>& labels) {
  return static_cast<size_t>(std::count(labels.begin(), labels.end(), -1));
}

// Numbers labels below num_labels by descending size. Returns the old label of
// each new one.
std::vector<int32_t> NumberBySize(size_t num_labels,
                                  std::vector<int32_t>* labels) {
  std::vector<size_t> size(num_labels, 0);
  for (const int32_t label : *labels) {
    if (label >= 0) ++size[label];
  }
  std::vector<int32_t> order;
  for (size_t label = 0; label < num_labels; ++label) {
    if (size[label] > 0) order.push_back(static_cast<int32_t>(label));
  }
  std::stable_sort(order.begin(), order.end(), [&](int32_t a, int32_t b) {
    return size[a] > size[b];
  });
  std::vector<int32_t> renumbered(num_labels, -1);
  for (size_t i = 0; i < order.size(); ++i) {
    renumbered[order[i]] = static_cast<int32_t>(i);
  }
  for (int32_t& label : *labels) {
    if (label >= 0) label = renumbered[label];
  }
  return order;
}

// The number that was counted most often, the smallest one of equals; nothing
// if none was counted.
std::optional<int32_t> MostFrequent(const std::map<int32_t, size_t>& counts) {
  const auto most = std::max_element(
      counts.begin(), counts.end(), [](const auto& x, const auto& y) {
        return x.second < y.second;
      });
  if (most == counts.end()) return std::nullopt;
  return most->first;
}

// Where most Gaussians of each label are in the hierarchy's own cut. Joins move
// crumbs of an instance elsewhere, so a single Gaussian does not tell.
std::vector<int32_t> RegionsOfLabels(const InstanceLabels& labels,
                                     const Hierarchy& hierarchy) {
  const HierarchyCut cut = CutHierarchy(hierarchy, hierarchy.granularity);
  std::vector<std::map<int32_t, size_t>> counts(labels.num_instances);
  for (size_t g = 0; g < labels.labels.size(); ++g) {
    const int32_t part = hierarchy.part_of_gaussian[g];
    if (labels.labels[g] < 0 || part < 0) continue;
    ++counts[labels.labels[g]][cut.region_of_part[part]];
  }
  std::vector<int32_t> regions;
  for (const std::map<int32_t, size_t>& count : counts) {
    regions.push_back(MostFrequent(count).value_or(-1));
  }
  return regions;
}

// Fills in all that follows from the labels. scores, is_plane: of each label as
// it is now.
void Number(const std::vector<double>& scores,
            const std::vector<uint8_t>& is_plane,
            InstanceLabels* result) {
  if (!result->labels.empty()) {
    result->noise_after = static_cast<double>(NumWithout(result->labels)) /
                          static_cast<double>(result->labels.size());
  }
  const std::vector<int32_t> order =
      NumberBySize(scores.size(), &result->labels);
  result->num_instances = static_cast<int>(order.size());
  for (const int32_t label : order) {
    result->scores.push_back(scores[label]);
    result->is_plane.push_back(is_plane[label]);
  }
}

}  // namespace

Status InstanceClusteringOptions::Check() const {
  FREEGS_RETURN_IF_ERROR(evidence.Check());
  return union_space.Check();
}

StatusOr<InstanceClusterer> InstanceClusterer::Create(
    const splat::GaussianModel& model,
    std::span<const View> views,
    const PhotoViews& photos,
    const InstanceClusteringOptions& options,
    ThreadPool& pool,
    const CancellationToken* cancellation) {
  FREEGS_RETURN_IF_ERROR(options.Check());
  InstanceClusterer clusterer(
      model, ComputeSceneExtent(model, views, kSceneOpacity, pool), options);
  if (IsCancelled(cancellation)) return Interrupted();
  if (options.method != ClusteringMethod::kEvidence) return clusterer;
  if (photos.views.empty()) {
    return InvalidArgumentError(
        "clustering by evidence needs photographs, and there are none; "
        "clustering in the union space does without");
  }
  FREEGS_ASSIGN_OR_RETURN(clusterer.models_, DefaultModels());
  FREEGS_ASSIGN_OR_RETURN(
      clusterer.divisions_,
      BuildScenePatches({.model = model,
                         .views = photos.views,
                         .render = photos.render,
                         .photo_of = photos.photo_of,
                         .scene_radius = clusterer.extent_.radius},
                        pool,
                        cancellation));
  return clusterer;
}

InstanceLabels InstanceClusterer::LabelsOf(EvidenceClusters clusters) const {
  InstanceLabels result;
  result.scene_radius = extent_.radius;
  result.hierarchy = std::move(clusters.hierarchy);
  result.division = clusters.division;
  result.agreement = clusters.agreement;
  result.labels = std::move(clusters.labels);
  result.planes = std::move(clusters.planes);
  result.num_clustered = clusters.num_clustered;
  Number(clusters.scores, clusters.is_plane, &result);
  return result;
}

StatusOr<InstanceLabels> InstanceClusterer::Cluster(
    const SemanticVectors& semantics,
    ThreadPool& pool,
    const CancellationToken* cancellation) {
  if (semantics.values.size() != model_->size() * semantics.dim) {
    return InvalidArgumentError("semantic vectors of another model");
  }
  if (IsCancelled(cancellation)) return Interrupted();
  if (options_.method == ClusteringMethod::kEvidence) {
    for (ScenePatches& patches : divisions_) {
      SetSemantics(semantics.values, semantics.dim, &patches);
    }
    if (IsCancelled(cancellation)) return Interrupted();
    FREEGS_ASSIGN_OR_RETURN(EvidenceClusters clusters,
                            ClusterByEvidence(*model_,
                                              divisions_,
                                              extent_.radius,
                                              kNoiseDistance * extent_.radius,
                                              models_,
                                              options_.evidence,
                                              pool));
    return LabelsOf(std::move(clusters));
  }
  FREEGS_ASSIGN_OR_RETURN(UnionClusters clusters,
                          ClusterInUnionSpace(*model_,
                                              semantics,
                                              extent_,
                                              options_.union_space,
                                              pool,
                                              cancellation));
  InstanceLabels result;
  result.scene_radius = extent_.radius;
  result.labels = std::move(clusters.labels);
  result.min_cluster_size = clusters.min_cluster_size;
  result.num_clustered = result.labels.size() - NumWithout(result.labels);
  LabelNoise(*model_, kNoiseDistance * extent_.radius, pool, &result.labels);
  Number(clusters.scores,
         std::vector<uint8_t>(clusters.scores.size(), 0),
         &result);
  return result;
}

std::vector<InstancePair> InstanceClusterer::PairsThatMeet(
    const InstanceLabels& labels) const {
  if (!labels.hierarchy) return {};
  return semantics::PairsThatMeet(
      *labels.hierarchy, divisions_[labels.division].graph, labels.is_plane);
}

JoinedInstances InstanceClusterer::Join(const InstanceLabels& labels,
                                        std::vector<WholePair> pairs) const {
  std::stable_sort(
      pairs.begin(), pairs.end(), [](const WholePair& x, const WholePair& y) {
        return x.confidence > y.confidence;
      });
  Hierarchy hierarchy = *labels.hierarchy;
  std::vector<InstancePair> made;
  std::vector<int32_t> regions = RegionsOfLabels(labels, hierarchy);
  for (const auto& [pair, confidence] : pairs) {
    const int32_t a = regions[pair.a];
    const int32_t b = regions[pair.b];
    // An earlier join may have taken one of the two into its whole.
    const auto num_labels =
        std::count_if(regions.begin(), regions.end(), [&](int32_t region) {
          return region == a || region == b;
        });
    if (a >= 0 && b >= 0 && a != b && num_labels == 2 &&
        JoinAsWhole(a, b, confidence, &hierarchy)) {
      made.push_back(pair);
      regions = RegionsOfLabels(labels, hierarchy);
    }
  }
  JoinedInstances joined;
  EvidenceClusters clusters = CutIntoClusters(
      std::move(hierarchy), divisions_[labels.division], extent_.radius);
  clusters.division = labels.division;
  clusters.agreement = labels.agreement;
  joined.labels = LabelsOf(std::move(clusters));
  // How many Gaussians of each label an instance has.
  std::vector<std::map<int32_t, size_t>> counts(joined.labels.num_instances);
  for (size_t g = 0; g < labels.labels.size(); ++g) {
    const int32_t label = joined.labels.labels[g];
    if (label >= 0 && labels.labels[g] >= 0) ++counts[label][labels.labels[g]];
  }
  for (const std::map<int32_t, size_t>& count : counts) {
    const int32_t label = MostFrequent(count).value_or(0);
    const auto pair =
        std::find_if(made.begin(), made.end(), [label](InstancePair one) {
          return one.a == label || one.b == label;
        });
    joined.made_of.push_back(pair == made.end() ? InstancePair{label, label}
                                                : *pair);
  }
  return joined;
}

}  // namespace freegs::semantics
