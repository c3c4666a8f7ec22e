// SPDX-License-Identifier: BSD-3-Clause

#include <cstdio>

#include "bench/training_modes.h"
#include "splat/images/holdout.h"
#include "splat/scene/ply_io.h"
#include "stages/scene/training_scene.h"

namespace freegs::bench {

Status RunEvaluate(const EvaluateOptions& options) {
  FREEGS_ASSIGN_OR_RETURN(const stages::TrainingScene scene,
                          stages::ReadTrainingScene(options.workspace));
  FREEGS_ASSIGN_OR_RETURN(const splat::PlacedModel world,
                          splat::ReadPly(options.ply));
  const splat::GaussianModel model = splat::ToFrame(world, scene.photos.frame);
  ThreadPool pool(options.threads);
  splat::TrainingImagesOptions image_options;
  image_options.max_side = options.max_image_size;
  image_options.num_levels = 1;
  if (scene.photos.holdout.empty()) return NoHoldoutError();
  FREEGS_ASSIGN_OR_RETURN(
      splat::TrainingImages holdout,
      stages::LoadPhotos(scene, scene.photos.holdout, image_options, pool));
  splat::RenderOptions render;
  render.background = options.background;
  FREEGS_ASSIGN_OR_RETURN(
      const splat::HoldoutReport report,
      splat::MeasureHoldout(
          {.model = model, .render = render, .images = &holdout}, pool));
  std::fprintf(
      stderr, "%zu Gaussians of SH degree %d\n", model.size(), model.sh_degree);
  std::printf("view,holdout_psnr,holdout_ssim\n");
  for (const splat::HoldoutView& view : report.views) {
    std::printf("%s,%.3f,%.4f\n", view.name.c_str(), view.psnr, view.ssim);
  }
  std::printf("mean,%.3f,%.4f\n", report.mean_psnr, report.mean_ssim);
  return Status();
}

}  // namespace freegs::bench
