// SPDX-License-Identifier: BSD-3-Clause
// Image quality on photographs that training never saw.

#ifndef FREEGS_SPLAT_IMAGES_HOLDOUT_H_
#define FREEGS_SPLAT_IMAGES_HOLDOUT_H_

#include <string>
#include <vector>

#include "core/image.h"
#include "core/parallel.h"
#include "core/status.h"
#include "splat/scene/gaussian_model.h"
#include "splat/render/renderer.h"
#include "splat/images/training_images.h"

namespace freegs::splat {

struct HoldoutView {
  std::string name;
  double psnr = 0;  // dB, of the 8-bit rendering against the 8-bit photo.
  double ssim = 0;
  ImageU8 rendered;
};

struct HoldoutReport {
  double mean_psnr = 0;  // Mean over views of the per-view figure.
  double mean_ssim = 0;
  std::vector<HoldoutView> views;
};

// Renders every view of `images` at a level of its pyramid and compares. Fails
// when a photo has become unreadable. `images` must not be empty.
StatusOr<HoldoutReport> MeasureHoldout(const GaussianModel& model,
                                       const RenderOptions& options,
                                       TrainingImages* images,
                                       ThreadPool& pool,
                                       int level = 0);

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_IMAGES_HOLDOUT_H_
