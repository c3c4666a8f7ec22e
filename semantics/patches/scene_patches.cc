// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/patches/scene_patches.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/area_average.h"
#include "core/io/image_io.h"
#include "core/kd_tree.h"
#include "core/quantile.h"
#include "semantics/geometry/local_geometry.h"
#include "semantics/geometry/matter.h"
#include "semantics/geometry/view_choice.h"
#include "semantics/geometry/view_loop.h"
#include "semantics/patches/patch_graph.h"
#include "semantics/patches/patches.h"
#include "semantics/patches/view_cues.h"
#include "splat/weights/blending_weights.h"

namespace freegs::semantics {
namespace {

// Gaussians of less opacity are haze and belong to no patch. So do those whose
// second largest standard deviation is larger, in scene radii (SceneExtent).
constexpr double kMinOpacity = 0.1;
constexpr double kMaxScale = 1;
// Extent of a patch in these photographs, in pixels.
constexpr double kPatchPixels = 8;
constexpr int kNormalNeighbors = 16;
constexpr double kDisparity = 3;  // Pixels.

Eigen::Vector3d MeanCentre(std::span<const View> views) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const View& view : views) mean += CameraCentre(view.cam_from_world);
  return mean / static_cast<double>(views.size());
}

// How far apart the cameras stand: twice the root mean squared distance from
// their mean, in units of the model frame.
double Baseline(std::span<const View> views) {
  const Eigen::Vector3d mean = MeanCentre(views);
  double spread2 = 0;
  for (const View& view : views) {
    spread2 += (CameraCentre(view.cam_from_world) - mean).squaredNorm();
  }
  return 2 * std::sqrt(spread2 / static_cast<double>(views.size()));
}

// How far apart two patches must be for it to show: the size of the patch or,
// where the cameras stand close together, the difference in depth that moves a
// point by kDisparity pixels between them. All views count as if they had the
// median focal length, so that a single one of another lens changes nothing.
std::vector<float> DepthScale(const std::vector<float>& positions,
                              const Patches& patches,
                              const std::vector<float>& size_of_patch,
                              std::span<const View> views) {
  const Eigen::Vector3d mean = MeanCentre(views);
  const double baseline = Baseline(views);
  std::vector<double> focal_lengths;
  for (const View& view : views) focal_lengths.push_back(view.camera.fx);
  const double focal_length = UpperMedian(std::move(focal_lengths));
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
                                             (focal_length * baseline)
                                       : distance;
    scale[p] = std::max(scale[p], static_cast<float>(unsure));
  }
  return scale;
}

// The chosen photographs of the scene, each of the size of its view. Several
// are read at once.
StatusOr<std::vector<ImageF>> ReadPhotos(
    const PatchScene& scene,
    std::span<const size_t> chosen,
    std::span<const View> views,
    ThreadPool& pool,
    const CancellationToken* cancellation) {
  std::vector<ImageF> photos(chosen.size());
  FREEGS_RETURN_IF_ERROR(ForEachView(
      "comparing patches",
      chosen.size(),
      pool,
      cancellation,
      [](size_t) {},
      [&](size_t v) -> Status {
        FREEGS_ASSIGN_OR_RETURN(const ImageU8 photo, scene.photo_of(chosen[v]));
        const Pinhole& camera = views[v].camera;
        photos[v] = ToFloat(AreaAverage(photo, camera.width, camera.height));
        return Status();
      }));
  return photos;
}

// What looks at the patches of a division. rows: the Gaussian of each point.
StatusOr<PatchGraphBuilder> Divide(const PatchScene& scene,
                                   const SurfacePoints& points,
                                   const std::vector<uint32_t>& rows,
                                   const std::vector<float>& sizes,
                                   std::span<const View> views,
                                   int division,
                                   ThreadPool& pool) {
  const size_t num_gaussians = scene.model.size();
  FREEGS_ASSIGN_OR_RETURN(const Patches patches,
                          MakePatches(points, sizes, division, pool));
  std::vector<int32_t> patch_of_gaussian(num_gaussians, -1);
  std::vector<float> size_of_patch(patches.count, 0.0f);
  std::vector<float> normals(num_gaussians * 3, 0.0f);
  for (size_t i = 0; i < rows.size(); ++i) {
    const int32_t patch = patches.patch_of_point[i];
    patch_of_gaussian[rows[i]] = patch;
    size_of_patch[patch] = std::max(size_of_patch[patch], sizes[i]);
    std::copy_n(
        points.normals.data() + i * 3, 3, normals.data() + size_t{rows[i]} * 3);
  }
  std::vector<float> depth_scale =
      DepthScale(points.positions, patches, size_of_patch, views);
  return PatchGraphBuilder(scene.model,
                           std::move(patch_of_gaussian),
                           normals,
                           std::move(size_of_patch),
                           std::move(depth_scale));
}

}  // namespace

StatusOr<std::vector<ScenePatches>> BuildScenePatches(
    const PatchScene& scene,
    ThreadPool& pool,
    const CancellationToken* cancellation) {
  const splat::GaussianModel& model = scene.model;
  Matter matter =
      SelectMatter(model, kMinOpacity, kMaxScale * scene.scene_radius);
  SurfacePoints points{.positions = std::move(matter.positions),
                       .normals = {},
                       .colors = std::move(matter.colors)};
  {
    FREEGS_ASSIGN_OR_RETURN(const KdTree tree,
                            KdTree::Build(points.positions, 3));
    points.normals = ComputeNormals(tree, kNormalNeighbors, pool);
  }
  const std::vector<size_t> chosen =
      ChooseViews(scene.views.size(), kMaxPatchViews);
  std::vector<View> views;
  for (const size_t v : chosen) {
    views.push_back(scene.views[v]);
    views.back().camera = views.back().camera.LimitedTo(kPatchImageSide);
  }
  const std::vector<float> sizes =
      LengthOfPixels(points.positions, views, kPatchPixels, pool);
  std::vector<double> seen(model.size(), 0.0);
  if (sizes.empty() || !(sizes[0] > 0)) {
    return std::vector<ScenePatches>(
        kNumDivisions,
        {.patch_of_gaussian = std::vector<int32_t>(model.size(), -1),
         .seen = seen,
         .graph = {}});
  }
  std::vector<PatchGraphBuilder> builders;
  for (int division = 0; division < kNumDivisions; ++division) {
    if (IsCancelled(cancellation)) {
      return InterruptedError("dividing the surfaces was interrupted");
    }
    FREEGS_ASSIGN_OR_RETURN(
        PatchGraphBuilder builder,
        Divide(scene, points, matter.rows, sizes, views, division, pool));
    builders.push_back(std::move(builder));
  }
  FREEGS_ASSIGN_OR_RETURN(const std::vector<ImageF> photos,
                          ReadPhotos(scene, chosen, views, pool, cancellation));
  const double baseline = Baseline(views);
  splat::BlendingWeights weights;
  for (size_t v = 0; v < chosen.size(); ++v) {
    if (IsCancelled(cancellation)) {
      return InterruptedError("comparing patches was interrupted");
    }
    FREEGS_RETURN_IF_ERROR(
        splat::ComputeBlendingWeights(model,
                                      views[v].camera,
                                      views[v].cam_from_world,
                                      scene.render,
                                      pool,
                                      &weights));
    const splat::WeightMatrix matrix = weights.matrix();
    FREEGS_ASSIGN_OR_RETURN(
        const ViewCues cues,
        FindViewCues(model, matrix, views[v], photos[v], baseline, pool));
    for (size_t e = 0; e < matrix.gaussians.size(); ++e) {
      seen[matrix.gaussians[e]] += matrix.weights[e];
    }
    pool.ParallelFor(
        0, kNumDivisions, 1, [&](int64_t first, int64_t last, int) {
          for (int64_t d = first; d < last; ++d) {
            builders[d].AddView(cues);
          }
        });
  }
  std::vector<ScenePatches> result;
  for (PatchGraphBuilder& builder : builders) {
    result.push_back({.patch_of_gaussian = builder.patch_of_gaussian(),
                      .seen = seen,
                      .graph = builder.Finish(seen)});
  }
  return result;
}

void SetSemantics(std::span<const float> semantics,
                  int dim,
                  ScenePatches* patches) {
  for (RegionStats& region : patches->graph.regions) {
    region.semantics.assign(dim, 0.0f);
  }
  for (size_t g = 0; g < patches->patch_of_gaussian.size(); ++g) {
    const int32_t patch = patches->patch_of_gaussian[g];
    if (patch < 0) continue;
    const std::span<const float> vector = semantics.subspan(g * dim, dim);
    double norm2 = 0;
    for (const float value : vector) norm2 += double{value} * value;
    if (!(norm2 > 0)) continue;
    const double scale = patches->seen[g] / std::sqrt(norm2);
    std::vector<float>& sum = patches->graph.regions[patch].semantics;
    for (int k = 0; k < dim; ++k) {
      sum[k] += static_cast<float>(scale * vector[k]);
    }
  }
}

}  // namespace freegs::semantics
