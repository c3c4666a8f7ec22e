// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/patches/scene_patches.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/io/image_io.h"
#include "core/kd_tree.h"
#include "semantics/geometry/local_geometry.h"
#include "semantics/patches/patch_graph.h"
#include "semantics/patches/patches.h"
#include "splat/weights/blending_weights.h"

namespace freegs::semantics {
namespace {

constexpr int kNormalNeighbors = 16;
constexpr double kDisparity = 3;  // Pixels.

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

// Evenly chosen views, with their cameras at the size of the comparison.
std::vector<size_t> ChooseViews(size_t count, int max_views) {
  const size_t chosen = std::min(count, static_cast<size_t>(max_views));
  std::vector<size_t> views;
  for (size_t i = 0; i < chosen; ++i) views.push_back(i * count / chosen);
  return views;
}

// How far apart two patches must be for it to show: the size of the patch or,
// where the cameras stand close together, the difference in depth that moves a
// point by kDisparity pixels between them.
std::vector<float> DepthScale(const std::vector<float>& positions,
                              const Patches& patches,
                              const std::vector<float>& size_of_patch,
                              std::span<const View> views) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const View& view : views) mean += CameraCentre(view.cam_from_world);
  mean /= static_cast<double>(views.size());
  double spread2 = 0;
  for (const View& view : views) {
    spread2 += (CameraCentre(view.cam_from_world) - mean).squaredNorm();
  }
  const double baseline =
      2 * std::sqrt(spread2 / static_cast<double>(views.size()));
  std::vector<Eigen::Vector3d> middle(patches.count, Eigen::Vector3d::Zero());
  std::vector<double> count(patches.count, 0.0);
  for (size_t i = 0; i < patches.patch_of_point.size(); ++i) {
    middle[patches.patch_of_point[i]] += Eigen::Vector3d(
        positions[i * 3], positions[i * 3 + 1], positions[i * 3 + 2]);
    count[patches.patch_of_point[i]] += 1;
  }
  std::vector<float> scale = size_of_patch;
  for (size_t p = 0; p < scale.size(); ++p) {
    const double distance = (middle[p] / count[p] - mean).norm();
    const double unsure = baseline > 0 ? kDisparity * distance * distance /
                                             (views[0].camera.fx * baseline)
                                       : distance;
    scale[p] = std::max(scale[p], static_cast<float>(unsure));
  }
  return scale;
}

}  // namespace

Status PatchOptions::Check() const {
  if (!(min_opacity >= 0) || !(max_scale > 0) || max_side < 16 ||
      max_views < 1 || !(patch_pixels > 0)) {
    return InvalidArgumentError(
        "options of patches must be positive, and max_side at least 16");
  }
  return Status();
}

StatusOr<ScenePatches> BuildScenePatches(
    const PatchScene& scene,
    const PatchOptions& options,
    ThreadPool& pool,
    const CancellationToken* cancellation) {
  FREEGS_RETURN_IF_ERROR(options.Check());
  const splat::GaussianModel& model = scene.model;
  const std::vector<uint32_t> rows = SelectMatter(
      model, options.min_opacity, options.max_scale * scene.scene_radius);
  SurfacePoints points;
  for (const uint32_t row : rows) {
    for (size_t k = 0; k < 3; ++k) {
      points.positions.push_back(model.means[row * size_t{3} + k]);
      points.colors.push_back(std::clamp(
          splat::kShC0 * model.sh_dc[row * size_t{3} + k] + 0.5f, 0.0f, 1.0f));
    }
  }
  {
    FREEGS_ASSIGN_OR_RETURN(const KdTree tree,
                            KdTree::Build(points.positions, 3));
    points.normals = ComputeNormals(tree, kNormalNeighbors, pool);
  }
  std::vector<View> views(scene.views.begin(), scene.views.end());
  for (View& view : views) {
    view.camera = view.camera.LimitedTo(options.max_side);
  }
  const std::vector<float> sizes =
      LengthOfPixels(points.positions, views, options.patch_pixels, pool);
  ScenePatches result;
  result.patch_of_gaussian.assign(model.size(), -1);
  if (sizes.empty() || !(sizes[0] > 0)) return result;
  FREEGS_ASSIGN_OR_RETURN(const Patches patches,
                          MakePatches(points, sizes, pool));
  std::vector<float> size_of_patch(patches.count, 0.0f);
  std::vector<float> normals(model.size() * 3, 0.0f);
  for (size_t i = 0; i < rows.size(); ++i) {
    const int32_t patch = patches.patch_of_point[i];
    result.patch_of_gaussian[rows[i]] = patch;
    size_of_patch[patch] = std::max(size_of_patch[patch], sizes[i]);
    std::copy_n(
        points.normals.data() + i * 3, 3, normals.data() + size_t{rows[i]} * 3);
  }
  std::vector<float> depth_scale =
      DepthScale(points.positions, patches, size_of_patch, views);
  PatchGraphBuilder builder(model,
                            result.patch_of_gaussian,
                            std::move(normals),
                            std::move(size_of_patch),
                            std::move(depth_scale));
  for (const size_t v : ChooseViews(views.size(), options.max_views)) {
    if (cancellation != nullptr && cancellation->cancelled()) {
      return InterruptedError("comparing patches was interrupted");
    }
    FREEGS_ASSIGN_OR_RETURN(
        const splat::BlendingWeights weights,
        splat::ComputeBlendingWeights(model,
                                      views[v].camera,
                                      views[v].cam_from_world,
                                      scene.render,
                                      pool));
    FREEGS_ASSIGN_OR_RETURN(const ImageU8 photo, scene.photo_of(v));
    const ImageF small =
        ToFloat(Resize(photo, views[v].camera.width, views[v].camera.height));
    FREEGS_RETURN_IF_ERROR(
        builder.AddView(weights.matrix(), views[v], small, pool));
  }
  result.graph = builder.Finish(scene.semantics, scene.dim);
  return result;
}

}  // namespace freegs::semantics
