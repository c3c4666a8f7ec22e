// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/field/feature_lifting.h"

#include <cmath>
#include <cstdint>
#include <string>

#include "splat/weights/blending_products.h"

namespace freegs::semantics {
namespace {

constexpr int64_t kGaussianGrain = 1024;

std::string ShapeOf(int width, int height, int channels) {
  return std::to_string(width) + " x " + std::to_string(height) + " x " +
         std::to_string(channels);
}

// channels: the number of channels of the views before, or 0.
Status CheckFeatures(const ImageF& features,
                     const Pinhole& camera,
                     int channels) {
  if (channels == 0) channels = features.channels();
  if (features.empty() || features.width() != camera.width ||
      features.height() != camera.height || features.channels() != channels) {
    return InvalidArgumentError(
        "features of shape " +
        ShapeOf(features.width(), features.height(), features.channels()) +
        " where " + ShapeOf(camera.width, camera.height, channels) +
        " are lifted");
  }
  bool finite = true;  // No early exit, so that the loop is vectorised.
  for (size_t k = 0; k < features.size(); ++k) {
    finite &= std::isfinite(features.data()[k]);
  }
  return finite ? Status()
                : InvalidArgumentError("features that are not finite");
}

}  // namespace

StatusOr<LiftedFeatures> LiftFeatures(ViewWeightsStore& store,
                                      ViewFeatures features_of,
                                      ThreadPool& pool) {
  if (store.num_views() == 0) {
    return InvalidArgumentError("there are no views to lift features from");
  }
  LiftedFeatures lifted;
  lifted.weights.assign(store.num_gaussians(), 0.0);
  for (size_t view = 0; view < store.num_views(); ++view) {
    FREEGS_ASSIGN_OR_RETURN(const ImageF features, features_of(view));
    const Status good =
        CheckFeatures(features, store.camera(view), lifted.channels);
    if (!good.ok()) return good.Annotated(store.name(view));
    if (view == 0) {
      lifted.channels = features.channels();
      lifted.features.assign(store.num_gaussians() * features.channels(), 0.0f);
    }
    FREEGS_ASSIGN_OR_RETURN(const ViewWeights weights,
                            store.Weights(view, pool));
    FREEGS_RETURN_IF_ERROR(splat::AddMultiplyTransposed(
        weights.matrix(),
        std::span(features.data(), features.size()),
        lifted.channels,
        pool,
        lifted.features));
    FREEGS_RETURN_IF_ERROR(
        splat::AddGaussianWeights(weights.matrix(), lifted.weights));
  }

  const auto count = static_cast<int64_t>(store.num_gaussians());
  const auto channels = static_cast<size_t>(lifted.channels);
  pool.ParallelFor(
      0, count, kGaussianGrain, [&](int64_t first, int64_t last, int) {
        for (int64_t i = first; i < last; ++i) {
          if (!lifted.seen(i)) continue;  // The feature is zero.
          float* feature = lifted.features.data() + i * channels;
          const double scale = 1 / lifted.weights[i];
          for (size_t c = 0; c < channels; ++c) {
            feature[c] = static_cast<float>(feature[c] * scale);
          }
        }
      });
  for (const double weight : lifted.weights) lifted.num_unseen += weight == 0;
  return lifted;
}

}  // namespace freegs::semantics
