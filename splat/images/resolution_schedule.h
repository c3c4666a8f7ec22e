// SPDX-License-Identifier: BSD-3-Clause
// Finds out how long training can use small images, which are cheap, from how
// much fine detail the photographs have.

#ifndef FREEGS_SPLAT_IMAGES_RESOLUTION_SCHEDULE_H_
#define FREEGS_SPLAT_IMAGES_RESOLUTION_SCHEDULE_H_

#include <vector>

#include "core/image.h"
#include "core/status.h"
#include "splat/images/training_images.h"

namespace freegs::splat {

// Returns, for each level of the image pyramid, the share of the spectrum that
// it keeps. Entry k is the sum of the amplitudes of all frequencies that an
// image of 1 / 2^k the size can show (both components below 0.5 / 2^k cycles
// per pixel), divided by the sum of all amplitudes. Entry 0 is 1; in natural
// images, whose amplitudes fall as 1 / f, about 1/2, 1/4, ... follow. The mean
// colour does not count, and a Hann window keeps the borders from counting as
// edges. `image` is H x W x 3.
std::vector<double> SpectrumShares(const ImageF& image, int num_levels);

// Returns the shares of the iterations at which training leaves each level but
// the finest, the coarsest level first; see ScheduleOptions::resolution_steps.
// Level k ends at a quarter of the spectrum share of level k, averaged over a
// few photos. The idea is that of DashGaussian (Chen et al. 2025): a resolution
// gets steps in proportion to the frequencies that it can show, so smooth
// photos stay small for longer than detailed ones. The quarter is a choice of
// ours; see docs/trials.md. Pixels that a mask ignores count as of one grey.
// Levels whose shorter side would be below 32 pixels are not used, so there may
// be fewer than num_levels - 1 entries. Fails when a photo has become
// unreadable.
StatusOr<std::vector<double>> SpectrumResolutionSteps(TrainingImages* images);

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_IMAGES_RESOLUTION_SCHEDULE_H_
