// SPDX-License-Identifier: BSD-3-Clause
// Renders a Gaussian model into a pinhole view: EWA projection, tiles, SIMD
// over pixels. Forward only; training uses Rasterizer and Projection directly.

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
  ImageF color;          // H x W x 3; with the background blended in.
  ImageF depth;          // H x W; z of the camera frame, blend-weighted mean of
                         // the Gaussians' centres, 0 where nothing is.
  ImageF transmittance;  // H x W; 1 where nothing is, 0 where opaque.
  ImageF features;       // H x W x C; sum of weight * value, no background.
};

// The same bytes for any number of threads.
RenderedView RenderView(const GaussianModel& model,
                        const Pinhole& camera,
                        const Rigid3d& cam_from_world,
                        const RenderOptions& options,
                        ThreadPool& pool,
                        const FeatureChannels& features = {});

// The label with the largest summed blending weight at each pixel: the argmax
// of rendered one-hot vectors (FreeGS eq. 5) without rendering the vectors.
// labels holds one value per Gaussian; negative labels take no part in the
// vote. Pixels where the voting Gaussians' weights sum to less than min_weight
// get -1. Ties go to the smaller label.
Image<int32_t> RenderLabels(const GaussianModel& model,
                            const Pinhole& camera,
                            const Rigid3d& cam_from_world,
                            const RenderOptions& options,
                            ThreadPool& pool,
                            std::span<const int32_t> labels,
                            float min_weight = 0.5f);

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_RENDER_RENDERER_H_
