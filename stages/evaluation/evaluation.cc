// SPDX-License-Identifier: BSD-3-Clause

#include "stages/evaluation/evaluation.h"

#include <filesystem>
#include <map>
#include <utility>

#include "core/io/image_io.h"
#include "splat/images/holdout.h"
#include "splat/images/training_images.h"
#include "splat/optim/image_metrics.h"
#include "splat/render/renderer.h"
#include "stages/scene/scene_alignment.h"
#include "stages/scene/training_scene.h"

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

StatusOr<std::optional<ImageQuality>> MeasureHoldoutQuality(
    const WorkspaceScene& scene,
    const fs::path& photos_folder,
    const fs::path& mask_folder,
    ThreadPool& pool) {
  if (scene.holdout.empty()) return std::optional<ImageQuality>();
  splat::TrainingImagesOptions options;
  options.max_side = scene.training_max_side;
  options.num_levels = 1;
  options.mask_folder = mask_folder;
  FREEGS_ASSIGN_OR_RETURN(
      splat::TrainingImages images,
      splat::TrainingImages::Load(scene.holdout, photos_folder, options, pool));
  FREEGS_ASSIGN_OR_RETURN(const splat::HoldoutReport report,
                          splat::MeasureHoldout(scene.model,
                                                scene.render,
                                                &images,
                                                pool,
                                                /*level=*/0,
                                                scene.exposures));
  if (report.views.empty()) return std::optional<ImageQuality>();
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
    // PSNR is defined on 8-bit pictures.
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
