// SPDX-License-Identifier: BSD-3-Clause
// Measures of how close a picture is to a photograph.

#ifndef FREEGS_SPLAT_OPTIM_IMAGE_METRICS_H_
#define FREEGS_SPLAT_OPTIM_IMAGE_METRICS_H_

#include "core/image.h"
#include "core/status.h"

namespace freegs::splat {

// The largest PSNR in dB; equal images have it.
inline constexpr double kMaxPsnr = 100;

// Both functions take two images of the same size, H x W x C. Values outside
// [0, 1] are clamped to it, as writing an image file would. All pixels and
// channels have the same weight. The functions fail with kInvalidArgument when
// the sizes differ or are zero, or when a value is NaN.

// The peak signal-to-noise ratio in dB: -10 log10 of the mean squared
// difference, at most kMaxPsnr.
StatusOr<double> Psnr(const ImageF& image, const ImageF& reference);

// The mean structural similarity (Wang, Bovik, Sheikh and Simoncelli 2004,
// eq. 13) with a Gaussian window of 11 x 11 pixels and standard deviation 1.5,
// K1 = 0.01, K2 = 0.03, and population (not sample) variances. As in 3DGS the
// images are continued with zeros, so that every pixel has a window. With a
// mask (H x W x 1) the mean is taken over the pixels where it is not 0, of
// which there must be one; their windows reach over the others.
StatusOr<double> Ssim(const ImageF& image,
                      const ImageF& reference,
                      const ImageU8* mask = nullptr);

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_OPTIM_IMAGE_METRICS_H_
