// SPDX-License-Identifier: BSD-3-Clause
// Measures image quality on photographs that training never saw.

#ifndef FREEGS_SPLAT_IMAGES_HOLDOUT_H_
#define FREEGS_SPLAT_IMAGES_HOLDOUT_H_

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/cancellation.h"
#include "core/image.h"
#include "core/parallel.h"
#include "core/status.h"
#include "splat/images/training_images.h"
#include "splat/optim/exposure.h"
#include "splat/render/renderer.h"
#include "splat/scene/gaussian_model.h"

namespace freegs::splat {

struct HoldoutView {
  std::string name;
  double psnr = 0;  // In dB, of the 8-bit rendering against the 8-bit photo.
  double ssim = 0;

  // How far the photo lies beside the rendering, in pixels: displacement.h.
  double displacement_px = 0;

  // Pairs of a splat and a tile that the rendering took: its work, as far as
  // that does not depend on the machine.
  int64_t tile_pairs = 0;
  ImageU8 rendered;
};

struct HoldoutReport {
  double mean_psnr = 0;  // The mean of the views' PSNR.
  double mean_ssim = 0;
  int64_t tile_pairs = 0;  // Of all views.
  std::vector<HoldoutView> views;
};

// What is measured: a model, in the views of photos.
struct HoldoutTask {
  const GaussianModel& model;
  RenderOptions render = {};
  TrainingImages* images = nullptr;  // One view or more.
  int level = 0;                     // Level of the image pyramid.

  // Where training learnt exposures, the colours of a rendering become those to
  // expect of the photo (ExposureBetween).
  std::span<const PhotoExposure> exposures = {};

  const CancellationToken* cancellation = nullptr;  // May be null.
};

// Renders every view and compares it with the photo, without the pixels that
// its mask ignores. A view of which nothing is left is not in the report, and
// the means of no views are 0. Fails when a photo has become unreadable.
// kInterrupted when cancelled.
//
//   FREEGS_ASSIGN_OR_RETURN(
//       const HoldoutReport report,
//       MeasureHoldout({.model = model, .images = &photos}, pool));
StatusOr<HoldoutReport> MeasureHoldout(const HoldoutTask& task,
                                       ThreadPool& pool);

// HoldoutReport::mean_psnr alone, in a fraction of the time and without the
// pictures; nothing if no view is left.
StatusOr<std::optional<double>> MeasureHoldoutPsnr(const HoldoutTask& task,
                                                   ThreadPool& pool);

// The mean PSNR in dB of the right half of photos, as they are and with fitted
// colours.
struct FittedPsnr {
  double plain = 0;
  double fitted = 0;
};

// Measures the holdout when each photo may have its own exposure: the colours
// of the rendering are fitted to the photo on its left half (FitColor) and
// compared on its right half. Exposures that training learnt are not used.
// Nothing if masks leave no pixel of any right half. The errors are those of
// MeasureHoldout.
StatusOr<std::optional<FittedPsnr>> MeasureFittedHoldout(
    const HoldoutTask& task, ThreadPool& pool);

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_IMAGES_HOLDOUT_H_
