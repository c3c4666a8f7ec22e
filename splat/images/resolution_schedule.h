// SPDX-License-Identifier: BSD-3-Clause
// When training may stop looking at small images: as late as what is in the
// photographs allows.

#ifndef FREEGS_SPLAT_IMAGES_RESOLUTION_SCHEDULE_H_
#define FREEGS_SPLAT_IMAGES_RESOLUTION_SCHEDULE_H_

#include <vector>

#include "core/image.h"
#include "core/status.h"
#include "splat/images/training_images.h"

namespace freegs::splat {

// The share of an image's spectrum that its pyramid keeps: entry k is the sum
// of the amplitudes of all frequencies that an image of 1 / 2^k the size can
// carry (each component below 0.5 / 2^k cycles per pixel), over the sum of all.
// The mean is left out, and a Hann window keeps the borders from counting as
// edges. Entry 0 is 1; natural images, whose amplitudes fall as 1 / f, have
// about 1/2, 1/4, ... `image` is H x W x 3.
std::vector<double> SpectrumShares(const ImageF& image, int num_levels);

// The shares of the iterations at which each coarser level is left, coarsest
// first: level k ends at a quarter of its spectrum share, averaged over a few
// photos (after DashGaussian, Chen et al. 2025: steps in proportion to the
// frequencies a resolution can teach). Smooth photos therefore stay small for
// longer than detailed ones. A quarter, because a step at full size teaches
// more than it costs more: see docs/performance.md. Levels whose shorter side
// would be under 32 pixels are not used: the result may have fewer than
// num_levels - 1 entries.
StatusOr<std::vector<double>> SpectrumResolutionSteps(TrainingImages* images);

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_IMAGES_RESOLUTION_SCHEDULE_H_
