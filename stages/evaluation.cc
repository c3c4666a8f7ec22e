// SPDX-License-Identifier: BSD-3-Clause

#include "stages/evaluation.h"

#include <filesystem>
#include <map>
#include <utility>

#include "core/image_io.h"
#include "splat/holdout.h"
#include "splat/image_metrics.h"
#include "splat/renderer.h"
#include "splat/training_images.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;

void FillMeans(ImageQuality* quality) {
  for (const ImageQuality::ViewQuality& view : quality->views) {
    quality->psnr += view.psnr;
    quality->ssim += view.ssim;
  }
  quality->psnr /= static_cast<double>(quality->views.size());
  quality->ssim /= static_cast<double>(quality->views.size());
}

Status Cancelled() { return InterruptedError("evaluation interrupted"); }

}  // namespace

StatusOr<sfm::PoseAlignment> AlignWithTruth(const WorkspaceScene& scene,
                                            const GroundTruth& truth) {
  sfm::NamedPoses target;
  std::map<std::string, std::vector<std::string>> names_by_stem;
  for (const View& view : truth.cameras.train) {
    target[view.name] = view.cam_from_world;
    names_by_stem[fs::path(view.name).stem().string()].push_back(view.name);
  }
  sfm::NamedPoses source;
  std::vector<const View*> without_match;
  for (const std::vector<View>* views : {&scene.train, &scene.holdout}) {
    for (const View& view : *views) {
      if (target.contains(view.name)) {
        source[view.name] = view.cam_from_world;
      } else {
        without_match.push_back(&view);
      }
    }
  }
  for (const View* view : without_match) {
    const auto found = names_by_stem.find(fs::path(view->name).stem().string());
    // A stem that several photos share says nothing.
    if (found != names_by_stem.end() && found->second.size() == 1) {
      source.emplace(found->second[0], view->cam_from_world);
    }
  }
  StatusOr<sfm::PoseAlignment> alignment = sfm::AlignPoses(source, target);
  if (!alignment.ok()) {
    return alignment.status().Annotated("aligning the scene with " +
                                        truth.folder.string());
  }
  return alignment;
}

std::vector<View> MapViews(const std::vector<View>& truth_views,
                           const Sim3d& truth_from_scene) {
  const Sim3d scene_from_truth = Inverse(truth_from_scene);
  std::vector<View> views = truth_views;
  for (View& view : views) {
    view.cam_from_world =
        TransformCamera(scene_from_truth, view.cam_from_world);
  }
  return views;
}

StatusOr<std::optional<ImageQuality>> MeasureHoldoutQuality(
    const WorkspaceScene& scene,
    const fs::path& photos_folder,
    ThreadPool& pool) {
  if (scene.holdout.empty()) return std::optional<ImageQuality>();
  splat::TrainingImagesOptions options;
  options.max_side = scene.training_max_side;
  options.num_levels = 1;
  FREEGS_ASSIGN_OR_RETURN(
      splat::TrainingImages images,
      splat::TrainingImages::Load(scene.holdout, photos_folder, options, pool));
  FREEGS_ASSIGN_OR_RETURN(
      const splat::HoldoutReport report,
      splat::MeasureHoldout(scene.model, scene.render, &images, pool));
  ImageQuality quality;
  for (const splat::HoldoutView& view : report.views) {
    quality.views.push_back({view.name, view.psnr, view.ssim});
  }
  FillMeans(&quality);
  return std::optional(std::move(quality));
}

StatusOr<std::optional<ImageQuality>> MeasureTestQuality(
    const WorkspaceScene& scene,
    const GroundTruth& truth,
    const Sim3d& truth_from_scene,
    const CancellationToken& cancellation,
    ThreadPool& pool) {
  ImageQuality quality;
  for (const View& view : MapViews(truth.cameras.test, truth_from_scene)) {
    const auto found = truth.photos.find(view.name);
    if (found == truth.photos.end()) continue;
    const fs::path& path = found->second;
    if (cancellation.cancelled()) return Cancelled();
    FREEGS_ASSIGN_OR_RETURN(const ImageU8 photo, ReadRgb(path));
    const splat::RenderedView rendered = splat::RenderView(
        scene.model, view.camera, view.cam_from_world, scene.render, pool);
    // As a file would have it.
    const ImageF picture = ToFloat(ToU8(rendered.color));
    const StatusOr<double> psnr = splat::Psnr(picture, ToFloat(photo));
    if (!psnr.ok()) {
      return BadInputError(path.string() + ": " + psnr.status().message());
    }
    FREEGS_ASSIGN_OR_RETURN(const double ssim,
                            splat::Ssim(picture, ToFloat(photo)));
    quality.views.push_back({view.name, *psnr, ssim});
  }
  if (quality.views.empty()) return std::optional<ImageQuality>();
  FillMeans(&quality);
  return std::optional(std::move(quality));
}

}  // namespace freegs::stages
