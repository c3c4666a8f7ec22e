// SPDX-License-Identifier: BSD-3-Clause
// Gaussian filtering by its definition, quadratic in the number of points, and
// images to try it on.

#ifndef FREEGS_TESTS_SEMANTICS_CRF_BRUTE_FORCE_H_
#define FREEGS_TESTS_SEMANTICS_CRF_BRUTE_FORCE_H_

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/image.h"
#include "core/random.h"

namespace freegs::semantics {

inline double GaussianKernel(std::span<const float> features,
                             int dim,
                             size_t i,
                             size_t j) {
  double squared = 0;
  for (int k = 0; k < dim; ++k) {
    const double difference =
        double{features[i * dim + k]} - features[j * dim + k];
    squared += difference * difference;
  }
  return std::exp(-squared / 2);
}

// K v, N x channels.
inline std::vector<double> BruteForceFilter(std::span<const float> features,
                                            int dim,
                                            std::span<const float> values,
                                            int channels) {
  const size_t points = features.size() / dim;
  std::vector<double> result(points * channels, 0.0);
  for (size_t i = 0; i < points; ++i) {
    for (size_t j = 0; j < points; ++j) {
      const double kernel = GaussianKernel(features, dim, i, j);
      for (int c = 0; c < channels; ++c) {
        result[i * channels + c] += kernel * values[j * channels + c];
      }
    }
  }
  return result;
}

// Features of all pixels, N x 5, or N x 2 where color_sigma is zero; sigmas in
// pixels and units of colour.
inline std::vector<float> PixelFeatures(const ImageF& image,
                                        double position_sigma,
                                        double color_sigma) {
  std::vector<float> features;
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      features.push_back(static_cast<float>(x / position_sigma));
      features.push_back(static_cast<float>(y / position_sigma));
      for (int c = 0; c < 3 && color_sigma > 0; ++c) {
        features.push_back(static_cast<float>(image(x, y, c) / color_sigma));
      }
    }
  }
  return features;
}

// Blobs of colour that change slowly, with an edge, and with noise.
inline ImageF SmoothImage(int width, int height, double noise, uint64_t seed) {
  ImageF image(width, height, 3);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      for (int c = 0; c < 3; ++c) {
        const double slow =
            std::sin(5.0 * x / width + c) * std::cos(4.0 * y / height - c);
        const double edge = 3 * x + y > 1.7 * width ? 0.25 : -0.1;
        const size_t counter = (size_t{3} * y * width) + 3 * x + c;
        image(x, y, c) =
            static_cast<float>(0.5 + 0.15 * slow + edge * (c - 1) +
                               noise * RandomNormal(seed, 0, counter));
      }
    }
  }
  return image;
}

}  // namespace freegs::semantics

#endif  // FREEGS_TESTS_SEMANTICS_CRF_BRUTE_FORCE_H_
