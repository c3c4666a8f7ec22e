// SPDX-License-Identifier: BSD-3-Clause
// The photometric loss of 3D Gaussian Splatting and its gradient.

#ifndef FREEGS_SPLAT_OPTIM_LOSS_H_
#define FREEGS_SPLAT_OPTIM_LOSS_H_

#include <vector>

#include "core/image.h"
#include "core/parallel.h"
#include "core/status.h"

namespace freegs::splat {

struct PhotometricLossOptions {
  // Share of the structural term: loss = (1 - w) L1 + w (1 - SSIM).
  double ssim_weight = 0.2;

  Status Check() const;
};

// Loss of a rendered against a photographed image, H x W x 3, values in [0, 1].
// L1 is the mean absolute difference; SSIM (Wang et al. 2004) is the mean over
// pixels and channels with an 11 x 11 Gaussian window of sigma 1.5,
// C1 = 0.01^2, C2 = 0.03^2 and zeros outside the image (Kerbl et al. 2023).
// Keeps its workspace between calls; one object serves one call at a time.
// The same bytes for any number of threads.
class PhotometricLoss {
 public:
  explicit PhotometricLoss(const PhotometricLossOptions& options = {});

  // The loss, and d loss / d rendered in *gradient (H x W x 3, resized when of
  // another size; null skips it). Images must be of the same size, 3 channels,
  // not empty.
  float Compute(const ImageF& rendered,
                const ImageF& target,
                ThreadPool& pool,
                ImageF* gradient);

 private:
  PhotometricLossOptions options_;

  // Maps and scratch rows, see loss.cc.
  std::vector<float> workspace_;
  std::vector<double> row_l1_;
  std::vector<double> row_ssim_;
};

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_OPTIM_LOSS_H_
