// SPDX-License-Identifier: BSD-3-Clause
// The differentiable renderer: projection, binning, blending and their
// derivatives for one view at a time.

#ifndef FREEGS_SPLAT_RENDER_RASTERIZER_H_
#define FREEGS_SPLAT_RENDER_RASTERIZER_H_

#include <cstdint>
#include <span>
#include <vector>

#include "core/image.h"
#include "core/parallel.h"
#include "core/pinhole.h"
#include "splat/projection/projection.h"
#include "splat/projection/render_options.h"
#include "splat/render/contributions.h"
#include "splat/render/projection_backward.h"
#include "splat/render/tile_bins.h"
#include "splat/scene/gaussian_model.h"

namespace freegs::splat {

// The results of Forward; all images are H x W.
struct RasterImages {
  ImageF color;          // 3 channels, background blended in.
  ImageF transmittance;  // 1 channel.
  // Further blended channels, without background: depth (the sum of weight * z)
  // when it was asked for, then the features.
  ImageF extras;
  // The Gaussian (index into the model) with the largest weight at each pixel,
  // -1 where nothing was blended. Left alone unless it was asked for.
  Image<int32_t> dominant;
};

// What Forward is to compute besides colour and transmittance.
struct RasterRequest {
  bool depth = false;             // Depth, in RasterImages::extras.
  bool dominant = false;          // RasterImages::dominant.
  FeatureChannels features = {};  // Features, in RasterImages::extras.
};

// The derivatives of the loss L with respect to the images of Forward. Null
// stands for zeros.
struct RasterGradients {
  const ImageF* color = nullptr;
  const ImageF* transmittance = nullptr;
  const ImageF* extras = nullptr;
};

// Usage, per training step:
//   rasterizer.Forward(model, camera, pose, options, {}, pool, &images);
//   ... dL/dcolor from the loss ...
//   rasterizer.BackwardInChunks(
//       model, {.color = &gradient}, images, pool,
//       [&](std::span<const uint32_t> visible, const GaussianGradients& rows) {
//         ... update the Gaussians in `visible` ...
//       });
// Keeps the intermediate results of the last view, which Backward needs, and
// its scratch memory, so that rendering view after view allocates nothing. The
// results are the same bytes for any number of threads.
class Rasterizer {
 public:
  void Forward(const GaussianModel& model,
               const Pinhole& camera,
               const Rigid3d& cam_from_world,
               const RenderOptions& options,
               const RasterRequest& request,
               ThreadPool& pool,
               RasterImages* images);

  // The derivatives of the last Forward, which must have had the same model and
  // have filled `images`. *gradients has the model's shapes; the rows of the
  // Gaussians that the view shows are overwritten, all others are left alone.
  // feature_gradients (N x channels) is treated likewise unless it is empty.
  void Backward(const GaussianModel& model,
                const RasterGradients& image_gradients,
                const RasterImages& images,
                ThreadPool& pool,
                GaussianGradients* gradients,
                std::span<float> feature_gradients = {});

  // Computes the same gradients, but hands them to `sink` chunk by chunk while
  // they are in the cache, instead of writing an array as large as the model.
  // Several threads call `sink`. It may update the Gaussians of its chunk in
  // the model, and only those; see ProjectionBackward::InChunks.
  void BackwardInChunks(const GaussianModel& model,
                        const RasterGradients& image_gradients,
                        const RasterImages& images,
                        ThreadPool& pool,
                        GradientSink sink);

  // Computes what each Gaussian contributes to a view, without the pixels where
  // the mask, of the view's size, is 0 (null: none). It replaces the results of
  // the last Forward, so Backward must not follow.
  void Contributions(const GaussianModel& model,
                     const Pinhole& camera,
                     const Rigid3d& cam_from_world,
                     const RenderOptions& options,
                     const ImageU8* mask,
                     ThreadPool& pool,
                     ViewContributions* contributions);

  // See RenderLabels. It replaces the results of the last Forward as well.
  Image<int32_t> Labels(const GaussianModel& model,
                        const Pinhole& camera,
                        const Rigid3d& cam_from_world,
                        const RenderOptions& options,
                        std::span<const int32_t> labels,
                        float min_weight,
                        ThreadPool& pool);

  // The splats of the last view.
  const Projection& projection() const { return projection_; }
  const TileBins& bins() const { return bins_; }

  // dL/d(mean in pixels) of the last backward pass, 2 floats for each of
  // projection().visible.
  std::span<const float> mean2d_gradients() const { return mean2d_gradients_; }

 private:
  TileTask MakeTask(int64_t tile) const;
  // Turns the derivatives of the images into those of the splats.
  SplatDerivatives BackwardPixels(const GaussianModel& model,
                                  const RasterGradients& image_gradients,
                                  const RasterImages& images,
                                  ThreadPool& pool);
  // Projects and bins. Colours are of degree 0 only: no caller looks at them.
  void PrepareWeights(const GaussianModel& model,
                      const Pinhole& camera,
                      const Rigid3d& cam_from_world,
                      const RenderOptions& options,
                      ThreadPool& pool);
  void StoreDominant(const TileTask& task,
                     const TileDominance& dominance,
                     Image<int32_t>* image) const;

  Projector projector_;
  Projection projection_;
  TileBins bins_;
  ProjectionBackward projection_backward_;
  Pinhole camera_;
  Rigid3d cam_from_world_;
  RenderOptions options_;
  bool with_depth_ = false;
  int num_features_ = 0;
  int num_extras_ = 0;

  std::vector<float> extras_;          // The model's: N x num_extras.
  std::vector<int64_t> tile_visited_;  // By tile, see BlendTile.
  std::vector<TileBlocks> touched_;    // By list entry, see BlendTile.
  std::vector<float> pair_moments_;    // By entry of the bins.
  std::vector<PairContribution> pair_contributions_;  // By entry of the bins.
  std::vector<float> mean2d_gradients_;
};

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_RENDER_RASTERIZER_H_
