// SPDX-License-Identifier: BSD-3-Clause

#include "splat/images/holdout.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <utility>

#include "core/io/image_io.h"
#include "splat/images/displacement.h"
#include "splat/images/ignored_pixels.h"
#include "splat/optim/image_metrics.h"
#include "splat/render/rasterizer.h"

namespace freegs::splat {
namespace {

// The PSNR in dB, at most kMaxPsnr, of a rendering in the columns from `begin`
// on, without the pixels that the mask ignores; nothing when it ignores all of
// them. `quantised` is what the 8-bit rendering shows.
std::optional<double> PsnrFrom(int begin,
                               const ImageF& quantised,
                               const ImageF& photo,
                               const ImageU8* mask) {
  double squared = 0;
  int64_t values = 0;
  for (int y = 0; y < photo.height(); ++y) {
    for (int x = begin; x < photo.width(); ++x) {
      if (mask != nullptr && (*mask)(x, y) == 0) continue;
      for (int c = 0; c < 3; ++c) {
        const double d =
            static_cast<double>(quantised(x, y, c)) - photo(x, y, c);
        squared += d * d;
        ++values;
      }
    }
  }
  if (values == 0) return std::nullopt;
  if (squared == 0) return kMaxPsnr;
  const double mean = squared / static_cast<double>(values);
  return std::min(kMaxPsnr, -10 * std::log10(mean));
}

// kInterrupted when cancelled.
Status CheckGoingOn(const CancellationToken* cancellation) {
  if (!IsCancelled(cancellation)) return Status();
  return InterruptedError("measuring holdout photos was interrupted");
}

// Renders the view of photo number i, and reads the photo.
Status RenderPhoto(const HoldoutTask& task,
                   size_t i,
                   ThreadPool& pool,
                   Rasterizer* rasterizer,
                   RasterImages* rendered,
                   ImageF* photo) {
  FREEGS_RETURN_IF_ERROR(CheckGoingOn(task.cancellation));
  const View view = task.images->view(i, task.level);
  FREEGS_RETURN_IF_ERROR(task.images->Fetch(i, task.level, photo));
  rasterizer->Forward(task.model,
                      view.camera,
                      view.cam_from_world,
                      task.render,
                      {},
                      pool,
                      rendered);
  return Status();
}

// Receives a view with its name, PSNR and picture, that picture in floats, and
// the photo with its mask, if it has one.
using ViewFn = std::function<Status(HoldoutView view,
                                    const ImageF& quantised,
                                    ImageF* photo,
                                    const ImageU8* mask)>;

// Returns the mean PSNR of the views of which masks leave something, or nothing
// without any. Calls `use` with each of these, if it is set.
StatusOr<std::optional<double>> CompareViews(const HoldoutTask& task,
                                             ThreadPool& pool,
                                             const ViewFn& use) {
  Rasterizer rasterizer;
  RasterImages rendered;
  ImageF photo;
  ImageF exposed;
  double sum = 0;
  size_t count = 0;
  for (size_t i = 0; i < task.images->size(); ++i) {
    FREEGS_RETURN_IF_ERROR(
        RenderPhoto(task, i, pool, &rasterizer, &rendered, &photo));
    HoldoutView result;
    result.name = task.images->view(i, task.level).name;
    result.tile_pairs = static_cast<int64_t>(rasterizer.bins().num_pairs());
    if (!task.exposures.empty()) {
      ApplyColor(ExposureBetween(task.exposures, result.name),
                 rendered.color,
                 pool,
                 &exposed);
    }
    result.rendered = ToU8(task.exposures.empty() ? rendered.color : exposed);
    const ImageF quantised = ToFloat(result.rendered);
    const ImageU8* const mask = task.images->Mask(i, task.level);
    const std::optional<double> psnr = PsnrFrom(0, quantised, photo, mask);
    if (!psnr) continue;
    result.psnr = *psnr;
    sum += *psnr;
    ++count;
    if (use) {
      FREEGS_RETURN_IF_ERROR(use(std::move(result), quantised, &photo, mask));
    }
  }
  if (count == 0) return std::optional<double>();
  return std::optional(sum / static_cast<double>(count));
}

}  // namespace

StatusOr<HoldoutReport> MeasureHoldout(const HoldoutTask& task,
                                       ThreadPool& pool) {
  HoldoutReport report;
  FREEGS_ASSIGN_OR_RETURN(
      const std::optional<double> mean_psnr,
      CompareViews(
          task,
          pool,
          [&](HoldoutView view,
              const ImageF& quantised,
              ImageF* photo,
              const ImageU8* mask) -> Status {
            view.displacement_px = Displacement(quantised, *photo, mask);
            // Windows that reach over ignored pixels find no error there.
            if (mask != nullptr) CopyIgnored(*mask, quantised, photo);
            FREEGS_ASSIGN_OR_RETURN(view.ssim, Ssim(quantised, *photo, mask));
            report.mean_ssim += view.ssim;
            report.tile_pairs += view.tile_pairs;
            report.views.push_back(std::move(view));
            return Status();
          }));
  if (!mean_psnr) return report;
  report.mean_psnr = *mean_psnr;
  report.mean_ssim /= static_cast<double>(report.views.size());
  return report;
}

StatusOr<std::optional<double>> MeasureHoldoutPsnr(const HoldoutTask& task,
                                                   ThreadPool& pool) {
  return CompareViews(task, pool, /*use=*/nullptr);
}

StatusOr<std::optional<FittedPsnr>> MeasureFittedHoldout(
    const HoldoutTask& task, ThreadPool& pool) {
  Rasterizer rasterizer;
  RasterImages rendered;
  ImageF photo;
  ImageF fitted;
  FittedPsnr sum;
  size_t count = 0;
  for (size_t i = 0; i < task.images->size(); ++i) {
    FREEGS_RETURN_IF_ERROR(
        RenderPhoto(task, i, pool, &rasterizer, &rendered, &photo));
    const ImageU8* const mask = task.images->Mask(i, task.level);
    const int middle = photo.width() / 2;
    ApplyColor(FitColor(rendered.color, photo, mask, 0, middle),
               rendered.color,
               pool,
               &fitted);
    const auto psnr = [&](const ImageF& image) {
      return PsnrFrom(middle, ToFloat(ToU8(image)), photo, mask);
    };
    const std::optional<double> plain = psnr(rendered.color);
    if (!plain) continue;
    sum.plain += *plain;
    sum.fitted += *psnr(fitted);
    ++count;
  }
  if (count == 0) return std::optional<FittedPsnr>();
  sum.plain /= static_cast<double>(count);
  sum.fitted /= static_cast<double>(count);
  return std::optional(sum);
}

}  // namespace freegs::splat
