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
  // The weight w of the structural term: loss = (1 - w) L1 + w (1 - SSIM).
  double ssim_weight = 0.2;

  Status Check() const;
};

// The loss of a rendered image against a photograph, both H x W x 3 with values
// in [0, 1]. L1 is the mean absolute difference. SSIM (Wang et al. 2004) is the
// mean over pixels and channels, with an 11 x 11 Gaussian window of standard
// deviation 1.5, C1 = 0.01^2, C2 = 0.03^2 and zeros outside the image (Kerbl et
// al. 2023).
//
// An object keeps its workspace between calls, so it serves one call at a time.
// The results are the same bytes for any number of threads.
//
//   PhotometricLoss loss;
//   ImageF gradient;
//   const float value = loss.Compute(rendered, photo, pool, &gradient);
class PhotometricLoss {
 public:
  explicit PhotometricLoss(const PhotometricLossOptions& options = {});

  // Returns the loss and writes its derivative with respect to `rendered` to
  // *gradient, which is made H x W x 3; null skips the derivative. The images
  // must be of the same size, have 3 channels and not be empty.
  float Compute(const ImageF& rendered,
                const ImageF& target,
                ThreadPool& pool,
                ImageF* gradient);

 private:
  // The size of the images, and where the parts of workspace_ begin.
  struct Layout;

  // Makes room for images of the size of `rendered`.
  Layout LayOut(const ImageF& rendered, int num_threads);

  // Fills row_l1_, row_ssim_ and the maps of the derivatives.
  void Forward(const ImageF& rendered,
               const ImageF& target,
               const Layout& layout,
               ThreadPool& pool);

  // Computes the gradient from the maps of the derivatives.
  void Backward(const ImageF& rendered,
                const ImageF& target,
                const Layout& layout,
                ThreadPool& pool,
                ImageF* gradient) const;

  PhotometricLossOptions options_;

  // A row of zeros, scratch rows and the maps of the derivatives, see loss.cc.
  std::vector<float> workspace_;
  size_t row_size_ = 0;  // That the workspace was laid out for, ...
  size_t head_ = 0;      // ... with so many numbers before the maps.
  std::vector<double> row_l1_;
  std::vector<double> row_ssim_;
};

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_OPTIM_LOSS_H_
