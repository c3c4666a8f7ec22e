// SPDX-License-Identifier: BSD-3-Clause
// Renders pictures of a Gaussian model.
//
//   ThreadPool pool(4);
//   const RenderedView view =
//       RenderView(model, camera, cam_from_world, RenderOptions(), pool);
//   WriteImage("view.png", ToU8(view.color));
//
// These functions allocate their memory anew at every call and cannot be
// differentiated; training uses Rasterizer.

#ifndef FREEGS_SPLAT_RENDER_RENDERER_H_
#define FREEGS_SPLAT_RENDER_RENDERER_H_

#include <cstdint>
#include <span>

#include "core/image.h"
#include "core/parallel.h"
#include "core/pinhole.h"
#include "splat/projection/render_options.h"
#include "splat/scene/gaussian_model.h"

namespace freegs::splat {

struct RenderedView {
  // H x W x 3, background blended in.
  ImageF color;
  // H x W: the mean of the z of the Gaussians' centres in the camera frame,
  // weighted by their blending weights; 0 where nothing was blended.
  ImageF depth;
  // H x W: 1 where nothing was blended, towards 0 where the model is opaque.
  ImageF transmittance;
  // H x W x channels: the sum of weight * value, without background.
  ImageF features;
};

// Renders a view, and blends `features` like colour when there are any. The
// result is the same bytes for any number of threads.
RenderedView RenderView(const GaussianModel& model,
                        const Pinhole& camera,
                        const Rigid3d& cam_from_world,
                        const RenderOptions& options,
                        ThreadPool& pool,
                        const FeatureChannels& features = {});

// A pixel that the labelled Gaussians cover less than this shows no label.
inline constexpr float kMinLabelWeight = 0.5f;

// Returns, for each pixel, the label whose Gaussians have the largest sum of
// blending weights there. This is the argmax of rendered one-hot vectors
// (FreeGS eq. 5), computed without rendering the vectors. `labels` holds one
// value per Gaussian; Gaussians with a negative label do not vote. A pixel
// where the weights of all votes sum to less than min_weight gets -1. Of
// several labels with the same sum the smallest is taken.
Image<int32_t> RenderLabels(const GaussianModel& model,
                            const Pinhole& camera,
                            const Rigid3d& cam_from_world,
                            const RenderOptions& options,
                            ThreadPool& pool,
                            std::span<const int32_t> labels,
                            float min_weight = kMinLabelWeight);

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_RENDER_RENDERER_H_
