// SPDX-License-Identifier: BSD-3-Clause
// Brings coarse features to the resolution of an image, such that their borders
// follow the borders in the image (joint bilateral upsampling; Kopf et al.
// 2007). FreeGS uses FeatUp for this, which has to be trained.

#ifndef FREEGS_SEMANTICS_CLIP_JOINT_BILATERAL_UPSAMPLING_H_
#define FREEGS_SEMANTICS_CLIP_JOINT_BILATERAL_UPSAMPLING_H_

#include <span>
#include <vector>

#include "core/image.h"
#include "core/parallel.h"
#include "core/status.h"

namespace freegs::semantics {

// The defaults are about the best ones for turning the shares that objects have
// in the cells of a grid into masks (docs/clip.md).
struct JointBilateralOptions {
  // How many cells on each side of the pixel's own cell count.
  int radius = 2;

  // Standard deviation of the weight over distance, in cells.
  double spatial_sigma = 0.5;

  // Standard deviation of the weight over the difference between the colours of
  // pixel and cell. In units of RGB, whose channels lie in [0, 1].
  double range_sigma = 0.15;

  Status Check() const;
};

struct PixelIndex {
  int x = 0;
  int y = 0;
};

// The feature of a pixel is the mean of the cells around it with the weights
//   exp(-|distance|^2 / (2 spatial_sigma^2))
//   exp(-|pixel's colour - cell's colour|^2 / (2 range_sigma^2)).
// The colour of a cell is the mean of the guide's pixels in it. The paper takes
// one pixel, which says little of a cell of 16 x 16 pixels. As a weighted mean,
// the result never leaves the range of the cells around it.
//
// features: w x h x C; its cells divide the guide evenly. guide: RGB in [0, 1],
// W x H x 3. Both finite. The result is W x H x C, and has the same bytes for
// any number of threads. kInvalidArgument for options out of range, empty
// images, a guide that does not have 3 channels, and more than 2^31 values in
// the result.
StatusOr<ImageF> JointBilateralUpsample(const ImageF& features,
                                        const ImageF& guide,
                                        const JointBilateralOptions& options,
                                        ThreadPool& pool);

// Does what JointBilateralUpsample does, for some pixels of the guide only:
// returns pixels.size() x C, row-major. kInvalidArgument also for pixels
// outside of the guide.
StatusOr<std::vector<float>> JointBilateralUpsampleAt(
    const ImageF& features,
    const ImageF& guide,
    std::span<const PixelIndex> pixels,
    const JointBilateralOptions& options,
    ThreadPool& pool);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_CLIP_JOINT_BILATERAL_UPSAMPLING_H_
