// SPDX-License-Identifier: BSD-3-Clause
// The photometric loss as its definition reads, for tests: no separable filter,
// no fusing, any scalar type.

#ifndef FREEGS_TESTS_SPLAT_REFERENCE_LOSS_H_
#define FREEGS_TESTS_SPLAT_REFERENCE_LOSS_H_

#include <cmath>

#include "core/image.h"

namespace freegs::splat {

template <typename T>
struct ReferenceLoss {
  T l1 = T(0);
  T ssim = T(0);
  T loss = T(0);
};

template <typename T>
ReferenceLoss<T> ComputeReferenceLoss(const Image<T>& rendered,
                                      const Image<T>& target,
                                      double ssim_weight) {
  using std::abs;
  constexpr int kRadius = 5;
  double window[11];
  double window_sum = 0;
  for (int k = 0; k < 11; ++k) {
    window[k] = std::exp(-(k - kRadius) * (k - kRadius) / (2 * 1.5 * 1.5));
    window_sum += window[k];
  }
  const int width = rendered.width();
  const int height = rendered.height();
  const double count = static_cast<double>(rendered.size());
  ReferenceLoss<T> result;
  for (int channel = 0; channel < 3; ++channel) {
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        T m1(0), m2(0), e11(0), e22(0), e12(0);
        for (int j = -kRadius; j <= kRadius; ++j) {
          for (int i = -kRadius; i <= kRadius; ++i) {
            if (x + i < 0 || x + i >= width || y + j < 0 || y + j >= height) {
              continue;
            }
            const double w = window[i + kRadius] * window[j + kRadius] /
                             (window_sum * window_sum);
            const T a = rendered(x + i, y + j, channel);
            const T b = target(x + i, y + j, channel);
            m1 += w * a;
            m2 += w * b;
            e11 += w * a * a;
            e22 += w * b * b;
            e12 += w * a * b;
          }
        }
        const double c1 = 0.01 * 0.01;
        const double c2 = 0.03 * 0.03;
        const T variance1 = e11 - m1 * m1;
        const T variance2 = e22 - m2 * m2;
        const T covariance = e12 - m1 * m2;
        result.ssim +=
            (2.0 * m1 * m2 + c1) * (2.0 * covariance + c2) /
            ((m1 * m1 + m2 * m2 + c1) * (variance1 + variance2 + c2)) / count;
        result.l1 +=
            abs(rendered(x, y, channel) - target(x, y, channel)) / count;
      }
    }
  }
  result.loss =
      (1.0 - ssim_weight) * result.l1 + ssim_weight * (1.0 - result.ssim);
  return result;
}

}  // namespace freegs::splat

#endif  // FREEGS_TESTS_SPLAT_REFERENCE_LOSS_H_
