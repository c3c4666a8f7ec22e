// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/instances/instance_clustering.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "core/kd_tree.h"
#include "semantics/geometry/directions.h"
#include "semantics/geometry/local_geometry.h"
#include "semantics/geometry/principal_axes.h"
#include "semantics/instances/cluster_merging.h"
#include "semantics/instances/crease_split.h"

namespace freegs::semantics {
namespace {

constexpr int kGeometryNeighbors = 24;
// The min_cluster_size if none is given: this share of the Gaussians that take
// part, and at least kMinClusterSize.
constexpr double kMinClusterShare = 0.003;
constexpr int kMinClusterSize = 30;
// Gaussians whose second largest standard deviation is larger, in scene radii,
// are haze and backdrop.
constexpr double kMaxScale = 0.1;
// Principal components of the semantic vectors that are clustered (FreeGS).
constexpr int kSemanticComponents = 6;
// Size of the patches that parts of clusters are made of, in scene radii.
constexpr double kCreasePatchSize = 0.1;
// What is behind a plane belongs to it up to this many scene radii.
constexpr double kBehindDistance = 0.1;

Status Interrupted() { return InterruptedError("clustering was interrupted"); }

std::vector<float> Gather(std::span<const float> values,
                          const std::vector<uint32_t>& rows,
                          size_t dim = 3) {
  std::vector<float> result(rows.size() * dim);
  for (size_t i = 0; i < rows.size(); ++i) {
    std::copy_n(values.data() + rows[i] * dim, dim, result.data() + i * dim);
  }
  return result;
}

// Reduces semantic vectors, N x *dim, for clustering: their directions are
// averaged over neighbours and projected onto their first principal axes.
// Returns N x *dim numbers, where *dim becomes the number of axes.
StatusOr<std::vector<float>> SemanticComponents(std::vector<float> vectors,
                                                const KdTree& tree,
                                                int num_neighbors,
                                                int max_components,
                                                ThreadPool& pool,
                                                int* dim) {
  if (*dim == 0 || max_components == 0 || vectors.empty()) {
    *dim = 0;
    return std::vector<float>();
  }
  MakeUnitRows(*dim, vectors);
  const std::vector<float> smooth =
      SmoothOverNeighbors(tree, vectors, *dim, num_neighbors, pool);
  FREEGS_ASSIGN_OR_RETURN(PrincipalAxes axes,
                          ComputePrincipalAxes(smooth, *dim, true, pool));
  axes.Keep(max_components);
  *dim = axes.count;
  return ProjectOntoAxes(axes, smooth, pool);
}

std::vector<float> BaseColors(const splat::GaussianModel& model) {
  std::vector<float> colors(model.sh_dc.size());
  for (size_t i = 0; i < colors.size(); ++i) {
    colors[i] = std::clamp(splat::kShC0 * model.sh_dc[i] + 0.5f, 0.0f, 1.0f);
  }
  return colors;
}

// Finite Gaussians that are opaque and small enough to be matter.
std::vector<uint32_t> SelectMatter(const splat::GaussianModel& model,
                                   double min_opacity,
                                   double max_scale) {
  std::vector<uint32_t> rows;
  for (uint32_t i = 0; i < model.size(); ++i) {
    const float* mean = model.means.data() + i * size_t{3};
    const double opacity = 1 / (1 + std::exp(-double{model.opacity_logits[i]}));
    std::array<float, 3> scales;
    std::copy_n(model.log_scales.data() + i * size_t{3}, 3, scales.begin());
    std::nth_element(scales.begin(), scales.begin() + 1, scales.end());
    const bool finite = std::all_of(mean, mean + 3, [](float x) {
      return std::abs(x) <= KdTree::kMaxCoordinate;
    });
    if (finite && opacity >= min_opacity && std::exp(scales[1]) <= max_scale) {
      rows.push_back(i);
    }
  }
  return rows;
}

// Points close behind a plane join it. Photographs show nothing behind a wall:
// what the reconstruction has there is the thickness of the wall. "Behind" is
// as most viewpoints see the plane.
void AbsorbBehindPlanes(std::span<const float> positions,
                        std::span<const View> views,
                        double behind_distance,
                        PlaneSegmentation* planes) {
  if (views.empty()) return;
  for (size_t p = 0; p < planes->planes.size(); ++p) {
    const Plane& plane = planes->planes[p];
    int in_front = 0;
    for (const View& view : views) {
      in_front +=
          plane.SignedDistance(CameraCentre(view.cam_from_world)) > 0 ? 1 : -1;
    }
    // A plane that is seen from both sides has no back.
    if (std::abs(in_front) < 0.8 * static_cast<double>(views.size())) {
      continue;
    }
    const double sign = in_front > 0 ? 1 : -1;
    for (size_t i = 0; i < planes->plane_index.size(); ++i) {
      if (planes->plane_index[i] >= 0) continue;
      const double distance =
          sign *
          plane.SignedDistance(Eigen::Vector3d(
              positions[i * 3], positions[i * 3 + 1], positions[i * 3 + 2]));
      if (distance < 0 && distance >= -behind_distance) {
        planes->plane_index[i] = static_cast<int32_t>(p);
      }
    }
  }
}

// Turns normals outward: towards the nearest camera, which sees the outside, or
// away from the centre of the scene if there are no cameras.
std::vector<float> OutwardNormals(std::span<const float> positions,
                                  std::vector<float> normals,
                                  std::span<const View> views,
                                  const SceneExtent& extent) {
  std::vector<Eigen::Vector3d> centers;
  for (const View& view : views) {
    centers.push_back(CameraCentre(view.cam_from_world));
  }
  for (size_t i = 0; i < positions.size(); i += 3) {
    const Eigen::Vector3d x(positions[i], positions[i + 1], positions[i + 2]);
    Eigen::Vector3d outward = x - extent.center;
    if (!centers.empty()) {
      outward = *std::min_element(centers.begin(),
                                  centers.end(),
                                  [&](const auto& a, const auto& b) {
                                    return (a - x).squaredNorm() <
                                           (b - x).squaredNorm();
                                  }) -
                x;
    }
    const Eigen::Vector3d normal(normals[i], normals[i + 1], normals[i + 2]);
    if (normal.dot(outward) < 0) {
      for (int k = 0; k < 3; ++k) normals[i + k] = -normals[i + k];
    }
  }
  return normals;
}

// Labels below min_size members become -1.
void DissolveSmall(size_t min_size, std::vector<int32_t>* labels) {
  int32_t num_labels = 0;
  for (const int32_t label : *labels) {
    num_labels = std::max(num_labels, label + 1);
  }
  std::vector<size_t> size(num_labels, 0);
  for (const int32_t label : *labels) {
    if (label >= 0) ++size[label];
  }
  for (int32_t& label : *labels) {
    if (label >= 0 && size[label] < min_size) label = -1;
  }
}

// Numbers labels by descending size. Returns the old label of each new one.
std::vector<int32_t> Renumber(std::vector<int32_t>* labels) {
  int32_t num_labels = 0;
  for (const int32_t label : *labels) {
    num_labels = std::max(num_labels, label + 1);
  }
  std::vector<size_t> size(num_labels, 0);
  for (const int32_t label : *labels) {
    if (label >= 0) ++size[label];
  }
  std::vector<int32_t> order;
  for (int32_t label = 0; label < num_labels; ++label) {
    if (size[label] > 0) order.push_back(label);
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

// The steps from a model to its instances; each uses what those before left.
class InstanceClusterer {
 public:
  InstanceClusterer(const splat::GaussianModel& model,
                    const SemanticVectors& semantics,
                    std::span<const View> views,
                    const PhotoViews& photos,
                    const InstanceClusteringOptions& options,
                    uint64_t seed,
                    ThreadPool& pool,
                    const CancellationToken* cancellation)
      : model_(model),
        semantics_(semantics),
        views_(views),
        photos_(photos),
        options_(options),
        seed_(seed),
        pool_(pool),
        cancellation_(cancellation) {}

  StatusOr<InstanceLabels> Run() {
    extent_ = ComputeSceneExtent(model_, views_, options_.min_opacity, pool_);
    result_.scene_radius = extent_.radius;
    if (cancelled()) return Interrupted();
    if (options_.method == ClusteringMethod::kEvidence &&
        !photos_.views.empty()) {
      FREEGS_RETURN_IF_ERROR(Evidence());
      return std::move(result_);
    }
    FREEGS_RETURN_IF_ERROR(CollectMatter());
    if (cancelled()) return Interrupted();
    TakeOutPlanes();
    if (cancelled()) return Interrupted();
    FREEGS_ASSIGN_OR_RETURN(const std::vector<float> points, UnionSpace());
    FREEGS_RETURN_IF_ERROR(FindClusters(points));
    RegroupClusters();
    LabelAll();
    NumberBySize();
    return std::move(result_);
  }

 private:
  Status Evidence() {
    FREEGS_ASSIGN_OR_RETURN(const EvidenceModel evidence,
                            DefaultEvidenceModel());
    FREEGS_ASSIGN_OR_RETURN(EvidenceClusters clusters,
                            ClusterByEvidence({.model = model_,
                                               .views = photos_.views,
                                               .render = photos_.render,
                                               .photo_of = photos_.photo_of,
                                               .semantics = semantics_.values,
                                               .dim = semantics_.dim,
                                               .scene_radius = extent_.radius},
                                              evidence,
                                              options_.evidence,
                                              pool_,
                                              cancellation_));
    result_.num_instances = static_cast<int>(clusters.scores.size());
    result_.labels = std::move(clusters.labels);
    result_.scores = std::move(clusters.scores);
    result_.is_plane = std::move(clusters.is_plane);
    result_.planes = std::move(clusters.planes);
    result_.hierarchy = std::move(clusters.hierarchy);
    for (const int32_t label : result_.labels) {
      result_.num_clustered += label >= 0;
    }
    return Status();
  }

  bool cancelled() const {
    return cancellation_ != nullptr && cancellation_->cancelled();
  }

  Status CollectMatter() {
    rows_ =
        SelectMatter(model_, options_.min_opacity, kMaxScale * extent_.radius);
    result_.num_clustered = rows_.size();
    positions_ = Gather(model_.means, rows_);
    colors_ = Gather(BaseColors(model_), rows_);
    FREEGS_ASSIGN_OR_RETURN(const KdTree tree, KdTree::Build(positions_, 3));
    normals_ = ComputeNormals(tree, kGeometryNeighbors, pool_);
    return Status();
  }

  void TakeOutPlanes() {
    planes_ = FindPlanes(
        positions_, normals_, extent_.radius, options_.planes, seed_, pool_);
    AbsorbBehindPlanes(
        positions_, views_, kBehindDistance * extent_.radius, &planes_);
    result_.planes = planes_.planes;
    for (uint32_t i = 0; i < rows_.size(); ++i) {
      if (planes_.plane_index[i] < 0) rest_.push_back(i);
    }
    result_.num_plane_points = rows_.size() - rest_.size();
    rest_positions_ = Gather(positions_, rest_);
  }

  // What is left, as rows for HDBSCAN.
  StatusOr<std::vector<float>> UnionSpace() {
    FREEGS_ASSIGN_OR_RETURN(const KdTree tree,
                            KdTree::Build(rest_positions_, 3));
    smooth_colors_ = SmoothOverNeighbors(
        tree, Gather(colors_, rest_), 3, options_.color_neighbors, pool_);
    std::vector<uint32_t> model_rows;
    for (const uint32_t i : rest_) model_rows.push_back(rows_[i]);
    int components = semantics_.dim;
    FREEGS_ASSIGN_OR_RETURN(
        const std::vector<float> meaning,
        SemanticComponents(
            Gather(semantics_.values, model_rows, semantics_.dim),
            tree,
            options_.color_neighbors,
            kSemanticComponents,
            pool_,
            &components));
    space_dim_ = 6 + components;
    return BuildUnionSpace(rest_positions_,
                           smooth_colors_,
                           meaning,
                           components,
                           extent_,
                           options_.space);
  }

  Status FindClusters(const std::vector<float>& points) {
    HdbscanOptions hdbscan = options_.hdbscan;
    if (hdbscan.min_cluster_size == 0) {
      hdbscan.min_cluster_size =
          std::max(kMinClusterSize,
                   static_cast<int>(kMinClusterShare *
                                    static_cast<double>(rows_.size())));
    }
    result_.min_cluster_size = hdbscan.min_cluster_size;
    FREEGS_ASSIGN_OR_RETURN(
        HdbscanResult clusters,
        Hdbscan(points, space_dim_, hdbscan, pool_, cancellation_));
    result_.num_clusters = clusters.num_clusters;
    size_t noise = 0;
    for (const int32_t label : clusters.labels) noise += label < 0;
    result_.noise_before =
        rows_.empty() ? 0.0 : static_cast<double>(noise) / rows_.size();
    labels_ = std::move(clusters.labels);
    probabilities_ = std::move(clusters.probabilities);
    return Status();
  }

  // Joins fragments of one thing and separates things that touch.
  void RegroupClusters() {
    if (options_.merge_color > 0) {
      MergeClusters(rest_positions_,
                    Gather(colors_, rest_),
                    options_.merge_distance * extent_.radius,
                    options_.merge_color,
                    pool_,
                    &labels_);
    }
    if (options_.min_crease_contrast > 0) {
      SplitAtCreases(
          rest_positions_,
          smooth_colors_,
          OutwardNormals(
              rest_positions_, Gather(normals_, rest_), views_, extent_),
          {.min_contrast = options_.min_crease_contrast,
           .patch_size = kCreasePatchSize * extent_.radius,
           .min_part_size = result_.min_cluster_size},
          pool_,
          &labels_);
    }
    DissolveSmall(options_.min_instance_size, &labels_);
  }

  // Back to all Gaussians. Planes have the first labels, then come clusters.
  void LabelAll() {
    result_.labels.assign(model_.size(), -1);
    for (size_t i = 0; i < rows_.size(); ++i) {
      result_.labels[rows_[i]] = planes_.plane_index[i];
    }
    int32_t num_labels = 0;
    for (const int32_t label : labels_) {
      num_labels = std::max(num_labels, label + 1);
    }
    score_sum_.assign(planes_.planes.size() + num_labels, 0.0);
    score_count_.assign(score_sum_.size(), 0);
    for (size_t i = 0; i < rest_.size(); ++i) {
      if (labels_[i] < 0) continue;
      const auto label =
          static_cast<int32_t>(planes_.planes.size()) + labels_[i];
      result_.labels[rows_[rest_[i]]] = label;
      score_sum_[label] += probabilities_[i];
      ++score_count_[label];
    }
    LabelRest();
  }

  // Gaussians without a label take that of the nearest one.
  void LabelRest() {
    std::vector<float> all_positions = model_.means;
    for (float& x : all_positions) {
      // A Gaussian that is nowhere finds no neighbour, and nobody finds it.
      if (!(std::abs(x) <= KdTree::kMaxCoordinate)) x = KdTree::kMaxCoordinate;
    }
    LabelNoise(all_positions,
               options_.noise_distance * extent_.radius,
               pool_,
               &result_.labels);
  }

  void NumberBySize() {
    const std::vector<int32_t> order = Renumber(&result_.labels);
    result_.num_instances = static_cast<int>(order.size());
    for (const int32_t label : order) {
      result_.is_plane.push_back(static_cast<size_t>(label) <
                                 planes_.planes.size());
      result_.scores.push_back(score_count_[label] > 0
                                   ? score_sum_[label] / score_count_[label]
                                   : 1.0);
    }
    size_t none = 0;
    for (const int32_t label : result_.labels) none += label < 0;
    result_.noise_after = result_.labels.empty() ? 0.0
                                                 : static_cast<double>(none) /
                                                       result_.labels.size();
  }

  const splat::GaussianModel& model_;
  const SemanticVectors& semantics_;
  const std::span<const View> views_;
  const PhotoViews& photos_;
  const InstanceClusteringOptions& options_;
  const uint64_t seed_;
  ThreadPool& pool_;
  const CancellationToken* const cancellation_;

  InstanceLabels result_;
  SceneExtent extent_;

  // The M Gaussians that take part: rows of the model, and M x 3 numbers each.
  std::vector<uint32_t> rows_;
  std::vector<float> positions_;
  std::vector<float> colors_;
  std::vector<float> normals_;
  PlaneSegmentation planes_;

  // The R of them that are in no plane: indices into rows_, and R x 3 numbers.
  std::vector<uint32_t> rest_;
  std::vector<float> rest_positions_;
  std::vector<float> smooth_colors_;  // Averaged over neighbours.
  int space_dim_ = 0;                 // Of the union space.
  std::vector<int32_t> labels_;       // R; -1 for noise.
  std::vector<float> probabilities_;  // R

  // Per label before numbering by size.
  std::vector<double> score_sum_;
  std::vector<size_t> score_count_;
};

}  // namespace

Status InstanceClusteringOptions::Check() const {
  FREEGS_RETURN_IF_ERROR(evidence.Check());
  FREEGS_RETURN_IF_ERROR(planes.Check());
  FREEGS_RETURN_IF_ERROR(space.Check());
  HdbscanOptions effective = hdbscan;
  if (effective.min_cluster_size == 0) effective.min_cluster_size = 2;
  FREEGS_RETURN_IF_ERROR(effective.Check());
  if (!(min_opacity >= 0 && min_opacity < 1)) {
    return InvalidArgumentError("min_opacity must lie in [0, 1)");
  }
  if (color_neighbors < 0 || color_neighbors > 1000) {
    return InvalidArgumentError("color_neighbors must lie in 0 .. 1000");
  }
  if (!(merge_color >= 0) || !(merge_distance >= 0) || !(noise_distance >= 0)) {
    return InvalidArgumentError(
        "merge_color, merge_distance and noise_distance must not be negative");
  }
  if (!(min_crease_contrast >= 0)) {
    return InvalidArgumentError("min_crease_contrast must not be negative");
  }
  if (min_instance_size < 1) {
    return InvalidArgumentError("min_instance_size must be at least 1");
  }
  return {};
}

StatusOr<InstanceLabels> ClusterInstances(
    const splat::GaussianModel& model,
    const SemanticVectors& semantics,
    std::span<const View> views,
    const PhotoViews& photos,
    const InstanceClusteringOptions& options,
    uint64_t seed,
    ThreadPool& pool,
    const CancellationToken* cancellation) {
  FREEGS_RETURN_IF_ERROR(options.Check());
  if (semantics.values.size() != model.size() * semantics.dim) {
    return InvalidArgumentError("semantic vectors of another model");
  }
  return InstanceClusterer(
             model, semantics, views, photos, options, seed, pool, cancellation)
      .Run();
}

}  // namespace freegs::semantics
