// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/patches/view_cues.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include <Eigen/Core>

namespace freegs::semantics {
namespace {

// Depth of the windows on both sides of a boundary, in pixels of images of
// which the longer side has kReferenceSide.
constexpr int kReferenceSide = 400;
constexpr double kNearReach = 3;
constexpr double kFarReach = 8;
constexpr double kReliefReach = 4;
// The inverse depth, per unit of the model frame, that cameras are unsure of
// when they all stand in one place: they see no depth at all.
constexpr double kNothingKnown = 1e9;
// A pixel shows a depth if the Gaussians have this much of its weight.
constexpr float kMinDepthWeight = 0.5f;
constexpr int64_t kPixelRowGrain = 4;

int Reach(double at_reference, const ImageF& image) {
  const int side = std::max(image.width(), image.height());
  return std::max(
      2, static_cast<int>(std::lround(at_reference * side / kReferenceSide)));
}

// The mean inverse depth that each pixel shows, per unit of the model frame, 0
// where the Gaussians have less than half of its weight.
ImageF InverseDepths(const splat::WeightMatrix& weights,
                     const splat::GaussianModel& model,
                     const View& view,
                     ThreadPool& pool) {
  std::vector<float> of_gaussian(model.size());
  for (size_t g = 0; g < model.size(); ++g) {
    const Eigen::Vector3d mean(
        model.means[g * 3], model.means[g * 3 + 1], model.means[g * 3 + 2]);
    const double z = (view.cam_from_world * mean).z();
    of_gaussian[g] = z > 0 ? static_cast<float>(1 / z) : 0.0f;
  }
  const int width = weights.width;
  ImageF image(width, weights.height, 1);
  pool.ParallelFor(
      0, weights.height, kPixelRowGrain, [&](int64_t first, int64_t last, int) {
        for (int64_t p = first * width; p < last * width; ++p) {
          float sum = 0;
          float total = 0;
          for (uint32_t e = weights.pixel_begin[p];
               e < weights.pixel_begin[p + 1];
               ++e) {
            sum += weights.weights[e] * of_gaussian[weights.gaussians[e]];
            total += weights.weights[e];
          }
          image.data()[p] = total >= kMinDepthWeight ? sum / total : 0.0f;
        }
      });
  return image;
}

}  // namespace

StatusOr<ViewCues> FindViewCues(const splat::GaussianModel& model,
                                const splat::WeightMatrix& weights,
                                const View& view,
                                const ImageF& photo,
                                double baseline,
                                ThreadPool& pool) {
  if (photo.width() != weights.width || photo.height() != weights.height ||
      view.camera.width != weights.width ||
      view.camera.height != weights.height ||
      weights.num_gaussians != model.size()) {
    return InvalidArgumentError(
        "weights, camera and photograph of a view differ in size");
  }
  // What one pixel of parallax amounts to.
  const double unsure =
      baseline > 0 ? 1 / (view.camera.fx * baseline) : kNothingKnown;
  const ImageF inverse_depths = InverseDepths(weights, model, view, pool);
  ImageF lab;
  std::optional<LocalContrast> contrast;
  std::optional<LocalRelief> relief;
  pool.ParallelFor(0, 2, 1, [&](int64_t first, int64_t last, int) {
    for (int64_t task = first; task < last; ++task) {
      if (task == 0) {
        lab = ToLab(photo);
        contrast.emplace(lab);
      } else {
        relief.emplace(inverse_depths, unsure);
      }
    }
  });
  return ViewCues{.weights = weights,
                  .view = view,
                  .lab = std::move(lab),
                  .contrast = *std::move(contrast),
                  .relief = *std::move(relief),
                  .near_reach = Reach(kNearReach, photo),
                  .far_reach = Reach(kFarReach, photo),
                  .relief_reach = Reach(kReliefReach, photo)};
}

}  // namespace freegs::semantics
