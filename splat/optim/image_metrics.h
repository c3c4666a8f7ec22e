// SPDX-License-Identifier: BSD-3-Clause
// How close a picture is to the photograph.

#ifndef FREEGS_SPLAT_OPTIM_IMAGE_METRICS_H_
#define FREEGS_SPLAT_OPTIM_IMAGE_METRICS_H_

#include "core/image.h"
#include "core/status.h"

namespace freegs::splat {

// What Psnr gives for equal images, and at most (dB).
inline constexpr double kMaxPsnr = 100;

// Both functions take images of the same size, H x W x C with values in [0, 1]
// (others are clamped, as a file would), sum in double precision, and weigh all
// pixels and channels alike. kInvalidArgument when sizes differ or are zero, or
// when a value is NaN.

// Peak signal-to-noise ratio in dB: -10 log10 of the mean squared difference.
StatusOr<double> Psnr(const ImageF& image, const ImageF& reference);

// Mean structural similarity (Wang, Bovik, Sheikh and Simoncelli 2004, eq. 13)
// with a Gaussian window of 11 x 11 pixels and standard deviation 1.5, K1 =
// 0.01, K2 = 0.03, and population (not sample) variances. As in 3DGS the
// images are continued with zeros, so that every pixel has a window.
StatusOr<double> Ssim(const ImageF& image, const ImageF& reference);

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_OPTIM_IMAGE_METRICS_H_
