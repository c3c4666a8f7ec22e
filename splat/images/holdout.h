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
  ImageU8 rendered;
};

struct HoldoutReport {
  double mean_psnr = 0;  // The mean of the views' PSNR.
  double mean_ssim = 0;
  std::vector<HoldoutView> views;
};

// Renders every view of `images` (one or more) at a level of the image pyramid
// and compares it with the photo, without the pixels that its mask ignores. A
// view of which nothing is left is not in the report, and the means of no views
// are 0. Where training learnt exposures, the colours of a rendering become
// those to expect of the photo (ExposureBetween). Fails when a photo has become
// unreadable. kInterrupted when cancelled (`cancellation` may be null).
StatusOr<HoldoutReport> MeasureHoldout(
    const GaussianModel& model,
    const RenderOptions& options,
    TrainingImages* images,
    ThreadPool& pool,
    int level = 0,
    std::span<const PhotoExposure> exposures = {},
    const CancellationToken* cancellation = nullptr);

// HoldoutReport::mean_psnr alone, in a fraction of the time and without the
// pictures; nothing if no view is left.
StatusOr<std::optional<double>> MeasureHoldoutPsnr(
    const GaussianModel& model,
    const RenderOptions& options,
    TrainingImages* images,
    ThreadPool& pool,
    int level = 0,
    std::span<const PhotoExposure> exposures = {},
    const CancellationToken* cancellation = nullptr);

// The mean PSNR in dB of the right half of photos, as they are and with fitted
// colours.
struct FittedPsnr {
  double plain = 0;
  double fitted = 0;
};

// The same when each photo may have its own exposure: the colours of the
// rendering are fitted to the photo on its left half (FitColor) and compared on
// its right half. Nothing if masks leave no pixel of any right half. The errors
// are those of MeasureHoldout.
StatusOr<std::optional<FittedPsnr>> MeasureFittedHoldout(
    const GaussianModel& model,
    const RenderOptions& options,
    TrainingImages* images,
    ThreadPool& pool,
    int level = 0,
    const CancellationToken* cancellation = nullptr);

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_IMAGES_HOLDOUT_H_
