// SPDX-License-Identifier: BSD-3-Clause
// Lets Gaussians fade that few photographs support. With few photographs, a
// Gaussian right in front of one of them can explain what that one shows, and
// no other photograph contradicts it. So every Gaussian loses some of its
// opacity all the time, and the gradients of the photographs that see it give
// it back. A Gaussian that only one photograph of fifteen sees should get too
// little back, fade, and be removed by the densification. The idea is that of
// Han et al., "Binocular-Guided 3D Gaussian Splatting", NeurIPS 2024, where a
// step takes 0.5 % of the opacity.
//
// The more photographs there are, the fewer of them see a Gaussian, and the
// less it may lose. With many photographs nothing needs to fade.

#ifndef FREEGS_SPLAT_DENSITY_OPACITY_DECAY_H_
#define FREEGS_SPLAT_DENSITY_OPACITY_DECAY_H_

#include <cstddef>

#include "core/parallel.h"
#include "core/status.h"
#include "splat/scene/gaussian_model.h"

namespace freegs::splat {

struct OpacityDecayOptions {
  // With n photographs, fewer than enough_photos, a Gaussian loses the share
  // strength * (1 / n - 1 / enough_photos) of its opacity at each step, but
  // at most max_share. With strength 0 nothing fades.
  double strength = 0.08;
  int enough_photos = 40;
  double max_share = 0.005;

  Status Check() const;
};

// The share of its opacity that a Gaussian loses at each step.
double OpacityDecayShare(const OpacityDecayOptions& options, size_t num_photos);

// Multiplies all opacities by 1 - share, where 0 <= share < 1, down to an
// opacity of 3e-7 (logit -15). The result is the same for any number of
// threads.
void DecayOpacity(double share, ThreadPool& pool, GaussianModel* model);

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_DENSITY_OPACITY_DECAY_H_
