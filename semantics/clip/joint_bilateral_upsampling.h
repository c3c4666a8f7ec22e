// SPDX-License-Identifier: BSD-3-Clause
// Coarse features at the resolution of an image, their borders where the
// image's are (joint bilateral upsampling; Kopf et al. 2007). Takes the place
// of FeatUp, which FreeGS uses and which has to be learnt.

#ifndef FREEGS_SEMANTICS_CLIP_JOINT_BILATERAL_UPSAMPLING_H_
#define FREEGS_SEMANTICS_CLIP_JOINT_BILATERAL_UPSAMPLING_H_

#include <span>
#include <vector>

#include "core/image.h"
#include "core/parallel.h"
#include "core/status.h"

namespace freegs::semantics {

// The defaults are about the best at turning the true shares of objects in the
// cells of a grid into their masks (docs/clip.md).
struct JointBilateralOptions {
  // Cells of the feature grid on each side of the pixel's own that count.
  int radius = 2;

  // Standard deviation of the weight over distance, in cells.
  double spatial_sigma = 0.5;

  // Standard deviation of the weight over the difference between the pixel's
  // colour and the cell's, as a distance in RGB with channels in [0, 1].
  double range_sigma = 0.15;

  Status Check() const;
};

struct PixelIndex {
  int x = 0;
  int y = 0;
};

// The feature of a pixel is the mean of the cells around it, weighted by
//   exp(-|distance|^2 / (2 spatial_sigma^2))
//   exp(-|pixel's colour - cell's colour|^2 / (2 range_sigma^2)),
// where a cell's colour is the mean of the guide's pixels below it: one pixel,
// as in the paper, says little of a cell of 16 x 16. A mean of weights that sum
// to one: nothing leaves the range of the cells around.
//
// features: w x h x C, whose cells share out the guide evenly. guide: RGB in
// [0, 1], W x H x 3. Both finite. The result is W x H x C, whatever the number
// of threads. kInvalidArgument for options out of range, empty images, a guide
// that has other than 3 channels, and more than 2^31 result values.
StatusOr<ImageF> JointBilateralUpsample(const ImageF& features,
                                        const ImageF& guide,
                                        const JointBilateralOptions& options,
                                        ThreadPool& pool);

// The same at some pixels of the guide only: pixels.size() x C, row-major.
// kInvalidArgument also for pixels outside the guide.
StatusOr<std::vector<float>> JointBilateralUpsampleAt(
    const ImageF& features,
    const ImageF& guide,
    std::span<const PixelIndex> pixels,
    const JointBilateralOptions& options,
    ThreadPool& pool);

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_CLIP_JOINT_BILATERAL_UPSAMPLING_H_
