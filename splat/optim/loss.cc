// SPDX-License-Identifier: BSD-3-Clause

#include "splat/optim/loss.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "splat/optim/loss_simd.h"

namespace freegs::splat {
namespace {

constexpr double kWindowSigma = 1.5;

// Rows per task.
constexpr int64_t kRowsPerTask = 2 * kSsimBlockRows;

SsimWindow MakeWindow() {
  std::array<double, kSsimWindowSize> weights;
  for (int k = 0; k < kSsimWindowSize; ++k) {
    const double offset = k - kSsimWindowRadius;
    weights[k] = std::exp(-offset * offset / (2 * kWindowSigma * kWindowSigma));
  }
  const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
  SsimWindow window;
  std::transform(weights.begin(), weights.end(), window.begin(), [=](double w) {
    return static_cast<float>(w / sum);
  });
  return window;
}

// The rows under the windows of the block that begins at row y, in a plane of
// `height` rows of `n` floats.
WindowRows RowsAround(
    const float* plane, const float* zeros, int height, size_t n, int y) {
  WindowRows rows;
  for (int k = 0; k < kSsimInputRows; ++k) {
    const int row = y + k - kSsimWindowRadius;
    rows[k] = row >= 0 && row < height ? plane + row * n : zeros;
  }
  return rows;
}

// Calls body(y, num_rows) for the blocks of rows [first, last).
template <typename Body>
void ForEachBlock(int64_t first, int64_t last, const Body& body) {
  for (int64_t y = first; y < last; y += kSsimBlockRows) {
    body(static_cast<int>(y),
         static_cast<int>(std::min<int64_t>(kSsimBlockRows, last - y)));
  }
}

}  // namespace

Status PhotometricLossOptions::Check() const {
  if (ssim_weight >= 0 && ssim_weight <= 1) return Status();
  return InvalidArgumentError("ssim_weight must be from 0 to 1");
}

PhotometricLoss::PhotometricLoss(const PhotometricLossOptions& options)
    : options_(options) {}

float PhotometricLoss::Compute(const ImageF& rendered,
                               const ImageF& target,
                               ThreadPool& pool,
                               ImageF* gradient) {
  const int height = rendered.height();
  const size_t n = 3 * static_cast<size_t>(rendered.width());
  const size_t plane = n * height;
  const size_t scratch_size = kSsimScratchRows * SsimScratchRow(n);

  // The workspace holds a row of zeros, the scratch rows of each worker, and
  // three maps of derivatives. Of the scratch rows only the padding must be
  // zero; calls that lay the workspace out in another way overwrite it.
  const size_t head = n + scratch_size * pool.num_threads();
  workspace_.resize(std::max(workspace_.size(), head + 3 * plane));
  if (row_size_ != n || head_ != head) {
    std::fill_n(workspace_.begin(), head, 0.0f);
    row_size_ = n;
    head_ = head;
  }
  const float* const zeros = workspace_.data();
  float* const scratch = workspace_.data() + n;
  float* const by_mean = workspace_.data() + head;
  float* const by_square = by_mean + plane;
  float* const by_product = by_square + plane;
  row_l1_.resize(height);
  row_ssim_.resize(height);

  const SsimWindow window = MakeWindow();
  pool.ParallelFor(
      0, height, kRowsPerTask, [&](int64_t first, int64_t last, int worker) {
        std::array<SsimDerivativeRow, kSsimBlockRows> derivatives;
        std::array<SsimRowSums, kSsimBlockRows> sums;
        ForEachBlock(first, last, [&](int y, int num_rows) {
          for (int r = 0; r < num_rows; ++r) {
            const size_t at = (y + r) * n;
            derivatives[r] = {by_mean + at, by_square + at, by_product + at};
          }
          SsimForwardRows(RowsAround(rendered.data(), zeros, height, n, y),
                          RowsAround(target.data(), zeros, height, n, y),
                          window,
                          n,
                          num_rows,
                          scratch + worker * scratch_size,
                          derivatives.data(),
                          sums.data());
          for (int r = 0; r < num_rows; ++r) {
            row_l1_[y + r] = sums[r].absolute_difference;
            row_ssim_[y + r] = sums[r].ssim;
          }
        });
      });
  const double count = static_cast<double>(plane);
  const double l1 =
      std::accumulate(row_l1_.begin(), row_l1_.end(), 0.0) / count;
  const double ssim =
      std::accumulate(row_ssim_.begin(), row_ssim_.end(), 0.0) / count;
  const double weight = options_.ssim_weight;

  if (gradient != nullptr) {
    gradient->Reshape(rendered.width(), height, 3);
    const auto l1_factor = static_cast<float>((1 - weight) / count);
    const auto ssim_factor = static_cast<float>(-weight / count);
    pool.ParallelFor(
        0, height, kRowsPerTask, [&](int64_t first, int64_t last, int worker) {
          ForEachBlock(first, last, [&](int y, int num_rows) {
            SsimBackwardRows({RowsAround(by_mean, zeros, height, n, y),
                              RowsAround(by_square, zeros, height, n, y),
                              RowsAround(by_product, zeros, height, n, y)},
                             rendered.row(y),
                             target.row(y),
                             window,
                             l1_factor,
                             ssim_factor,
                             n,
                             num_rows,
                             scratch + worker * scratch_size,
                             gradient->row(y));
          });
        });
  }
  return static_cast<float>((1 - weight) * l1 + weight * (1 - ssim));
}

}  // namespace freegs::splat
