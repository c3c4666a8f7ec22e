// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/instances/instance_clustering.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "semantics/instances/cluster_merging.h"
#include "semantics/instances/crease_split.h"
#include "semantics/geometry/directions.h"
#include "core/kd_tree.h"
#include "semantics/geometry/local_geometry.h"
#include "semantics/geometry/principal_axes.h"

namespace freegs::semantics {
namespace {

constexpr int kGeometryNeighbors = 24;
// Of the Gaussians that take part, where no min_cluster_size is given.
constexpr double kMinClusterShare = 0.003;
constexpr int kMinClusterSize = 30;
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

// What clustering sees of semantic vectors, N x dim: their directions, averaged
// over neighbours, by their first principal components; N x *dim, which is
// lowered to the number of these.
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

// A wall has nothing behind it that the photos show; what the reconstruction
// put there is its own thickness. Points beyond the plane as most viewpoints
// see it, but near, join it.
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
    // Seen from both sides: no back.
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

// The sign of a normal follows from the nearest camera: it sees the outside.
// Without cameras, outward is away from the scene's centre.
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

// Numbers labels by descending size; returns old label of each new one.
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

}  // namespace

Status InstanceClusteringOptions::Check() const {
  FREEGS_RETURN_IF_ERROR(planes.Check());
  FREEGS_RETURN_IF_ERROR(space.Check());
  HdbscanOptions effective = hdbscan;
  if (effective.min_cluster_size == 0) effective.min_cluster_size = 2;
  FREEGS_RETURN_IF_ERROR(effective.Check());
  if (!(min_opacity >= 0 && min_opacity < 1)) {
    return InvalidArgumentError("min_opacity must lie in [0, 1)");
  }
  if (!(max_scale > 0)) {
    return InvalidArgumentError("max_scale must be positive");
  }
  if (color_neighbors < 0 || color_neighbors > 1000) {
    return InvalidArgumentError("color_neighbors must lie in 0 .. 1000");
  }
  if (!(merge_color >= 0) || !(merge_distance >= 0) || !(noise_distance >= 0)) {
    return InvalidArgumentError(
        "merge_color, merge_distance and noise_distance must not be negative");
  }
  if (!(min_crease_contrast >= 0) || !(crease_patch_size > 0)) {
    return InvalidArgumentError(
        "min_crease_contrast must not be negative and crease_patch_size must "
        "be "
        "positive");
  }
  if (semantic_components < 0 || semantic_components > 1000) {
    return InvalidArgumentError("semantic_components must lie in 0 .. 1000");
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
    const InstanceClusteringOptions& options,
    uint64_t seed,
    ThreadPool& pool,
    const CancellationToken* cancellation) {
  FREEGS_RETURN_IF_ERROR(options.Check());
  if (semantics.values.size() != model.size() * semantics.dim) {
    return InvalidArgumentError("semantic vectors of another model");
  }
  const auto cancelled = [&] {
    return cancellation != nullptr && cancellation->cancelled();
  };
  InstanceLabels result;
  result.labels.assign(model.size(), -1);

  const SceneExtent extent =
      ComputeSceneExtent(model, views, options.min_opacity, pool);
  result.scene_radius = extent.radius;
  if (cancelled()) return Interrupted();
  const std::vector<uint32_t> rows = SelectMatter(
      model, options.min_opacity, options.max_scale * extent.radius);
  result.num_clustered = rows.size();
  const std::vector<float> positions = Gather(model.means, rows);
  const std::vector<float> colors = Gather(BaseColors(model), rows);

  FREEGS_ASSIGN_OR_RETURN(const KdTree tree, KdTree::Build(positions, 3));
  const std::vector<float> normals =
      ComputeNormals(tree, kGeometryNeighbors, pool);
  if (cancelled()) return Interrupted();
  PlaneSegmentation planes =
      FindPlanes(positions, normals, extent.radius, options.planes, seed, pool);
  AbsorbBehindPlanes(
      positions, views, kBehindDistance * extent.radius, &planes);
  const auto num_planes = static_cast<int32_t>(planes.planes.size());
  result.planes = planes.planes;
  if (cancelled()) return Interrupted();

  // Cluster what is left, in the union space.
  std::vector<uint32_t> rest;  // Into rows.
  for (uint32_t i = 0; i < rows.size(); ++i) {
    if (planes.plane_index[i] < 0) rest.push_back(i);
  }
  result.num_plane_points = rows.size() - rest.size();
  const std::vector<float> rest_positions = Gather(positions, rest);
  const std::vector<float> rest_colors = Gather(colors, rest);
  FREEGS_ASSIGN_OR_RETURN(const KdTree rest_tree,
                          KdTree::Build(rest_positions, 3));
  const std::vector<float> smooth_colors = SmoothOverNeighbors(
      rest_tree, rest_colors, 3, options.color_neighbors, pool);
  std::vector<uint32_t> rest_rows;  // Into the model.
  for (const uint32_t i : rest) rest_rows.push_back(rows[i]);
  int components = semantics.dim;
  FREEGS_ASSIGN_OR_RETURN(
      const std::vector<float> meaning,
      SemanticComponents(Gather(semantics.values, rest_rows, semantics.dim),
                         rest_tree,
                         options.color_neighbors,
                         options.semantic_components,
                         pool,
                         &components));
  const std::vector<float> points = BuildUnionSpace(rest_positions,
                                                    smooth_colors,
                                                    meaning,
                                                    components,
                                                    extent,
                                                    options.space);
  HdbscanOptions hdbscan = options.hdbscan;
  if (hdbscan.min_cluster_size == 0) {
    hdbscan.min_cluster_size = std::max(
        kMinClusterSize,
        static_cast<int>(kMinClusterShare * static_cast<double>(rows.size())));
  }
  result.min_cluster_size = hdbscan.min_cluster_size;
  FREEGS_ASSIGN_OR_RETURN(
      HdbscanResult clusters,
      Hdbscan(points, 6 + components, hdbscan, pool, cancellation));
  result.num_clusters = clusters.num_clusters;
  size_t noise = 0;
  for (const int32_t label : clusters.labels) noise += label < 0;
  result.noise_before =
      rows.empty() ? 0.0 : static_cast<double>(noise) / rows.size();

  std::vector<int32_t> labels = clusters.labels;
  if (options.merge_color > 0) {
    MergeClusters(rest_positions,
                  rest_colors,
                  options.merge_distance * extent.radius,
                  options.merge_color,
                  pool,
                  &labels);
  }
  if (options.min_crease_contrast > 0) {
    const std::vector<float> outward =
        OutwardNormals(rest_positions, Gather(normals, rest), views, extent);
    SplitAtCreases(rest_positions,
                   smooth_colors,
                   outward,
                   {.min_contrast = options.min_crease_contrast,
                    .patch_size = options.crease_patch_size * extent.radius,
                    .min_part_size = hdbscan.min_cluster_size},
                   pool,
                   &labels);
  }
  DissolveSmall(options.min_instance_size, &labels);

  // Back to all Gaussians: planes are labels 0 .. num_planes - 1 for now.
  for (size_t i = 0; i < rows.size(); ++i) {
    result.labels[rows[i]] = planes.plane_index[i];
  }
  int32_t num_labels = 0;
  for (const int32_t label : labels) {
    num_labels = std::max(num_labels, label + 1);
  }
  std::vector<double> score_sum(num_planes + num_labels, 0.0);
  std::vector<size_t> score_count(score_sum.size(), 0);
  for (size_t i = 0; i < rest.size(); ++i) {
    if (labels[i] < 0) continue;
    const int32_t label = num_planes + labels[i];
    result.labels[rows[rest[i]]] = label;
    score_sum[label] += clusters.probabilities[i];
    ++score_count[label];
  }
  std::vector<float> all_positions = model.means;
  for (float& x : all_positions) {
    // Not to be found: a Gaussian that is nowhere has no neighbours.
    if (!(std::abs(x) <= KdTree::kMaxCoordinate)) x = KdTree::kMaxCoordinate;
  }
  LabelNoise(all_positions,
             options.noise_distance * extent.radius,
             pool,
             &result.labels);

  const std::vector<int32_t> order = Renumber(&result.labels);
  result.num_instances = static_cast<int>(order.size());
  for (const int32_t label : order) {
    result.is_plane.push_back(label < num_planes);
    result.scores.push_back(
        score_count[label] > 0 ? score_sum[label] / score_count[label] : 1.0);
  }
  size_t none = 0;
  for (const int32_t label : result.labels) none += label < 0;
  result.noise_after = result.labels.empty()
                           ? 0.0
                           : static_cast<double>(none) / result.labels.size();
  return result;
}

}  // namespace freegs::semantics
