// SPDX-License-Identifier: BSD-3-Clause
// What each Gaussian gives to the picture of one view: the raw material of blur
// split, depth reinitialisation and importance (Fang and Wang 2024, section 4).

#ifndef FREEGS_SPLAT_RENDER_CONTRIBUTIONS_H_
#define FREEGS_SPLAT_RENDER_CONTRIBUTIONS_H_

#include <cstdint>
#include <vector>

#include "core/image.h"

namespace freegs::splat {

struct ViewContributions {
  // The Gaussians the view shows, nearest first; the next three arrays are
  // parallel to it.
  std::vector<uint32_t> model_index;

  // Sum over the pixels of the blending weight alpha T.
  std::vector<float> weight_sum;

  // Pixels blended into, and those where the weight was the largest of all.
  std::vector<uint32_t> num_pixels;
  std::vector<uint32_t> num_dominant;

  // Per pixel, H x W: the Gaussian (index into the model) of the largest
  // weight, -1 where nothing was blended; ties go to the nearest.
  Image<int32_t> dominant;

  // Per pixel, H x W: what shines through all of them.
  ImageF transmittance;
};

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_RENDER_CONTRIBUTIONS_H_
