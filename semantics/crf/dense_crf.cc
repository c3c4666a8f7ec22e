// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/crf/dense_crf.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>

namespace freegs::semantics {
namespace {

constexpr int64_t kPixelGrain = 2048;
constexpr int kMaxLabels = 65535;
constexpr uint64_t kMaxValues = uint64_t{1} << 31;

// e^x for x <= 0 including minus infinity, with a relative error of 3e-7;
// exactly zero below about -87.7. It has no branches, so that the compiler
// vectorises loops over it.
inline float ExpOfNegative(float x) {
  constexpr float kLowest = -88.0f;  // Its power of two has zero bits only.
  constexpr float kLog2E = 1.44269504f;
  // ln 2 in two parts. Products of the first with small integers are exact.
  constexpr float kLn2High = 0.693359375f;
  constexpr float kLn2Low = -2.12194440e-4f;
  const float y = x > kLowest ? x : kLowest;
  const auto exponent = static_cast<int32_t>(y * kLog2E - 0.5f);
  const auto n = static_cast<float>(exponent);
  const float r = (y - n * kLn2High) - n * kLn2Low;
  // Taylor's polynomial: |r| <= ln 2 / 2.
  float p = 1.0f / 720;
  p = p * r + 1.0f / 120;
  p = p * r + 1.0f / 24;
  p = p * r + 1.0f / 6;
  p = p * r + 0.5f;
  p = p * r + 1.0f;
  p = p * r + 1.0f;
  const float power = std::bit_cast<float>((exponent + 127) << 23);
  return p * power;
}

// The distribution proportional to e^logit. The largest logit must be finite.
void Softmax(const float* logits, int num_labels, float* probabilities) {
  const float largest = *std::max_element(logits, logits + num_labels);
  for (int l = 0; l < num_labels; ++l) {
    probabilities[l] = ExpOfNegative(logits[l] - largest);
  }
  float sum = 0;  // At least 1, the term of the largest logit.
  for (int l = 0; l < num_labels; ++l) sum += probabilities[l];
  const float scale = 1 / sum;
  for (int l = 0; l < num_labels; ++l) probabilities[l] *= scale;
}

// Calls body(pixel) for all pixels.
template <typename Body>
void ForPixels(size_t num_pixels, ThreadPool& pool, const Body& body) {
  pool.ParallelFor(0,
                   static_cast<int64_t>(num_pixels),
                   kPixelGrain,
                   [&](int64_t first, int64_t last, int) {
                     for (int64_t pixel = first; pixel < last; ++pixel) {
                       body(static_cast<size_t>(pixel));
                     }
                   });
}

}  // namespace

Status DenseCrfOptions::Check() const {
  for (const double weight : {appearance_weight, smoothness_weight}) {
    if (!(weight >= 0 && weight <= 1000)) {
      return InvalidArgumentError(
          "the weights of CRF kernels must lie in 0 .. 1000");
    }
  }
  for (const double sigma : {appearance_position_sigma,
                             appearance_color_sigma,
                             smoothness_position_sigma}) {
    if (!(sigma >= 1e-4 && sigma <= 100)) {
      return InvalidArgumentError(
          "the sigmas of CRF kernels must lie in 0.0001 .. 100");
    }
  }
  if (iterations < 0 || iterations > 1000) {
    return InvalidArgumentError("CRF iterations must lie in 0 .. 1000");
  }
  return Status();
}

StatusOr<DenseCrf> DenseCrf::Build(const ImageF& image,
                                   const DenseCrfOptions& options,
                                   ThreadPool& pool) {
  FREEGS_RETURN_IF_ERROR(options.Check());
  if (image.empty() || image.channels() != 3) {
    return InvalidArgumentError("a CRF needs an RGB image that is not empty");
  }
  DenseCrf crf;
  crf.width_ = image.width();
  crf.height_ = image.height();
  crf.iterations_ = options.iterations;
  const size_t num_pixels = image.num_pixels();
  crf.self_weights_.assign(num_pixels, 0.0f);

  // Writes the features of all pixels: position, and colour where dim is 5.
  const double side = std::sqrt(static_cast<double>(num_pixels));
  const auto add_kernel = [&](int dim, double position_sigma, double weight) {
    if (weight == 0) return Status();
    std::vector<float> features(num_pixels * dim);
    const double per_pixel = 1 / (position_sigma * side);
    ForPixels(num_pixels, pool, [&](size_t pixel) {
      float* feature = features.data() + pixel * dim;
      feature[0] = static_cast<float>(per_pixel * (pixel % image.width()));
      feature[1] = static_cast<float>(per_pixel * (pixel / image.width()));
      for (int c = 0; c < dim - 2; ++c) {
        feature[2 + c] = static_cast<float>(image.data()[pixel * 3 + c] /
                                            options.appearance_color_sigma);
      }
    });
    return crf.AddKernel(features, dim, weight, pool);
  };
  FREEGS_RETURN_IF_ERROR(add_kernel(
      5, options.appearance_position_sigma, options.appearance_weight));
  FREEGS_RETURN_IF_ERROR(add_kernel(
      2, options.smoothness_position_sigma, options.smoothness_weight));
  return crf;
}

Status DenseCrf::AddKernel(const std::vector<float>& features,
                           int dim,
                           double weight,
                           ThreadPool& pool) {
  auto lattice = PermutohedralLattice::Build(features, dim, pool);
  if (!lattice.ok()) return lattice.status().Annotated("kernel of a CRF");
  lattice->NormalizeSymmetrically(pool);
  ForPixels(self_weights_.size(), pool, [&](size_t pixel) {
    self_weights_[pixel] +=
        static_cast<float>(weight * lattice->SelfResponse(pixel));
  });
  kernels_.push_back({std::move(*lattice), static_cast<float>(weight)});
  return Status();
}

Status DenseCrf::CheckUnary(const ImageF& unary, ThreadPool& pool) const {
  if (unary.width() != width_ || unary.height() != height_) {
    return InvalidArgumentError(
        "unary energies of " + std::to_string(unary.width()) + " x " +
        std::to_string(unary.height()) + " pixels do not fit an image of " +
        std::to_string(width_) + " x " + std::to_string(height_));
  }
  const int num_labels = unary.channels();
  if (num_labels < 1 || num_labels > kMaxLabels) {
    return InvalidArgumentError("a CRF takes 1 .. " +
                                std::to_string(kMaxLabels) + " labels");
  }
  if (unary.size() > kMaxValues) {
    return InvalidArgumentError(
        std::to_string(num_labels) + " labels are too many for a CRF of " +
        std::to_string(unary.num_pixels()) + " pixels; use a smaller image");
  }
  std::vector<uint8_t> bad_rows(height_, 0);
  pool.ParallelFor(0, height_, 1, [&](int64_t first, int64_t last, int) {
    for (auto y = static_cast<int>(first); y < last; ++y) {
      for (int x = 0; x < width_; ++x) {
        bool allowed = false;
        const float* energies = &unary(x, y);
        for (int l = 0; l < num_labels; ++l) {
          if (!(energies[l] > -HUGE_VALF)) bad_rows[y] = 1;
          allowed = allowed || energies[l] < HUGE_VALF;
        }
        if (!allowed) bad_rows[y] = 1;
      }
    }
  });
  const auto bad = std::find(bad_rows.begin(), bad_rows.end(), 1);
  if (bad != bad_rows.end()) {
    return InvalidArgumentError(
        "row " + std::to_string(bad - bad_rows.begin()) +
        " of the unary energies has NaN or minus infinity, or a pixel that "
        "may have no label");
  }
  return Status();
}

StatusOr<DenseCrfResult> DenseCrf::Infer(const ImageF& unary,
                                         ThreadPool& pool) const {
  FREEGS_RETURN_IF_ERROR(CheckUnary(unary, pool));
  const int num_labels = unary.channels();
  const size_t num_pixels = unary.num_pixels();
  DenseCrfResult result;
  result.probabilities = ImageF(width_, height_, num_labels);
  float* probabilities = result.probabilities.data();

  std::vector<float> logits(unary.size());
  LatticeBuffers buffers;
  for (int iteration = 0; iteration <= iterations_; ++iteration) {
    // A label gains from a small energy and from similar pixels that have it,
    // without the pixel itself. Under the Potts model the penalty for other
    // labels is the same up to a constant per pixel.
    ForPixels(num_pixels, pool, [&](size_t pixel) {
      const size_t row = pixel * num_labels;
      const float self = iteration == 0 ? 0.0f : self_weights_[pixel];
      for (size_t k = row; k < row + num_labels; ++k) {
        logits[k] = -unary.data()[k] - self * probabilities[k];
      }
    });
    if (iteration > 0) {
      for (const Kernel& kernel : kernels_) {
        FREEGS_RETURN_IF_ERROR(
            kernel.lattice.AddFiltered({probabilities, unary.size()},
                                       num_labels,
                                       kernel.weight,
                                       pool,
                                       &buffers,
                                       logits));
      }
    }
    ForPixels(num_pixels, pool, [&](size_t pixel) {
      Softmax(logits.data() + pixel * num_labels,
              num_labels,
              probabilities + pixel * num_labels);
    });
  }

  result.labels = ImageU16(width_, height_, 1);
  ForPixels(num_pixels, pool, [&](size_t pixel) {
    const float* row = probabilities + pixel * num_labels;
    result.labels.data()[pixel] =
        static_cast<uint16_t>(std::max_element(row, row + num_labels) - row);
  });
  return result;
}

}  // namespace freegs::semantics
