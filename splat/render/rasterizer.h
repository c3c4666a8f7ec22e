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
#include "splat/render/contributions.h"
#include "splat/scene/gaussian_model.h"
#include "splat/projection/projection.h"
#include "splat/render/projection_backward.h"
#include "splat/projection/render_options.h"
#include "splat/render/tile_bins.h"

namespace freegs::splat {

// What Forward produced; the images are H x W.
struct RasterImages {
  ImageF color;          // 3 channels, background blended in.
  ImageF transmittance;  // 1 channel.
  // num_extras channels, no background: first depth (sum of weight * z) when
  // asked for, then the features.
  ImageF extras;
  // Per pixel the Gaussian (index into the model) of the largest weight, -1
  // where nothing is; when asked for, else left alone.
  Image<int32_t> dominant;
};

// What Forward makes beside colour and transmittance.
struct RasterRequest {
  bool depth = false;             // An extra channel.
  bool dominant = false;          // RasterImages::dominant.
  FeatureChannels features = {};  // N x channels per Gaussian.
};

// dL/d(images) for Backward; null counts as zero.
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
// Holds the intermediate results and scratch memory of the last view, so that
// the large arrays are not allocated anew. The results are the same bytes for
// any number of threads.
class Rasterizer {
 public:
  void Forward(const GaussianModel& model,
               const Pinhole& camera,
               const Rigid3d& cam_from_world,
               const RenderOptions& options,
               const RasterRequest& request,
               ThreadPool& pool,
               RasterImages* images);

  // Derivatives of the last Forward, which must have had the same model. Rows
  // of *gradients (shaped like the model) of Gaussians that the view shows are
  // overwritten; the others are left alone. feature_gradients: N x channels,
  // likewise, when not empty.
  void Backward(const GaussianModel& model,
                const RasterGradients& image_gradients,
                const RasterImages& images,
                ThreadPool& pool,
                GaussianGradients* gradients,
                std::span<float> feature_gradients = {});

  // The same gradients, handed over chunk by chunk while they are in the cache
  // instead of being written to an array as large as the model. `sink` is
  // called by several threads and may update the Gaussians of its chunk in
  // *model, and only those; see ProjectionBackward::InChunks.
  void BackwardInChunks(const GaussianModel& model,
                        const RasterGradients& image_gradients,
                        const RasterImages& images,
                        ThreadPool& pool,
                        GradientSink sink);

  // What each Gaussian gives to a view. Afterwards Backward is not possible.
  void Contributions(const GaussianModel& model,
                     const Pinhole& camera,
                     const Rigid3d& cam_from_world,
                     const RenderOptions& options,
                     ThreadPool& pool,
                     ViewContributions* contributions);

  // The argmax of voted weights per pixel; see RenderLabels.
  Image<int32_t> Labels(const GaussianModel& model,
                        const Pinhole& camera,
                        const Rigid3d& cam_from_world,
                        const RenderOptions& options,
                        std::span<const int32_t> labels,
                        float min_weight,
                        ThreadPool& pool);

  // The splats of the last view, nearest first.
  const Projection& projection() const { return projection_; }
  const TileBins& bins() const { return bins_; }

  // After a backward pass: dL/d(2D mean) in pixels, 2 floats per splat.
  std::span<const float> mean2d_gradients() const { return mean2d_gradients_; }

 private:
  TileTask MakeTask(int64_t tile) const;
  // From derivatives of the images to those of the splats.
  SplatDerivatives BackwardPixels(const GaussianModel& model,
                                  const RasterGradients& image_gradients,
                                  const RasterImages& images,
                                  ThreadPool& pool);
  // Projects and bins without evaluating view-dependent colour.
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

  std::vector<float> splat_extras_;    // num_splats x num_extras.
  std::vector<int64_t> tile_visited_;  // Per tile, see BlendTile.
  std::vector<float> pair_moments_;    // By entry of the bins.
  std::vector<PairContribution> pair_contributions_;  // Likewise.
  std::vector<float> mean2d_gradients_;
};

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_RENDER_RASTERIZER_H_
