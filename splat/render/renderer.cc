// SPDX-License-Identifier: BSD-3-Clause

#include "splat/render/renderer.h"

#include <algorithm>

#include "splat/render/rasterizer.h"

namespace freegs::splat {

RenderedView RenderView(const GaussianModel& model,
                        const Pinhole& camera,
                        const Rigid3d& cam_from_world,
                        const RenderOptions& options,
                        ThreadPool& pool,
                        const FeatureChannels& features) {
  Rasterizer rasterizer;
  RasterImages images;
  rasterizer.Forward(model,
                     camera,
                     cam_from_world,
                     options,
                     {.depth = true, .features = features},
                     pool,
                     &images);
  RenderedView view;
  view.depth = ImageF(camera.width, camera.height, 1);
  view.features = ImageF(camera.width, camera.height, features.channels);
  const int extras = images.extras.channels();
  for (size_t k = 0; k < images.transmittance.num_pixels(); ++k) {
    const float weight = 1.0f - images.transmittance.data()[k];
    const float* values = images.extras.data() + k * extras;
    view.depth.data()[k] = weight > 1e-6f ? values[0] / weight : 0.0f;
    std::copy_n(values + 1,
                features.channels,
                view.features.data() + k * features.channels);
  }
  view.color = std::move(images.color);
  view.transmittance = std::move(images.transmittance);
  return view;
}

Image<int32_t> RenderLabels(const GaussianModel& model,
                            const Pinhole& camera,
                            const Rigid3d& cam_from_world,
                            const RenderOptions& options,
                            ThreadPool& pool,
                            std::span<const int32_t> labels,
                            float min_weight) {
  Rasterizer rasterizer;
  return rasterizer.Labels(
      model, camera, cam_from_world, options, labels, min_weight, pool);
}

}  // namespace freegs::splat
