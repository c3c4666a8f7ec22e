// SPDX-License-Identifier: BSD-3-Clause
// How much each Gaussian contributes to the picture of one view. Blur split,
// depth reinitialisation and importance are computed from it (Fang and Wang
// 2024, Mini-Splatting, section 4).

#ifndef FREEGS_SPLAT_RENDER_CONTRIBUTIONS_H_
#define FREEGS_SPLAT_RENDER_CONTRIBUTIONS_H_

#include <cstdint>
#include <vector>

#include "core/image.h"

namespace freegs::splat {

struct ViewContributions {
  // The Gaussians that the view shows (indices into the model), ascending. The
  // next three arrays are parallel to it.
  std::vector<uint32_t> model_index;

  // The sum over the pixels of the blending weight alpha T.
  std::vector<float> weight_sum;

  // The number of pixels that the Gaussian was blended into, and of those where
  // its weight was the largest of all Gaussians.
  std::vector<uint32_t> num_pixels;
  std::vector<uint32_t> num_dominant;

  // H x W: the Gaussian (index into the model) with the largest weight at each
  // pixel, the nearest of several, or -1 where nothing was blended.
  Image<int32_t> dominant;

  // H x W: the share of light that passes all Gaussians; 0 where a mask ignores
  // the pixel.
  ImageF transmittance;
};

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_RENDER_CONTRIBUTIONS_H_
