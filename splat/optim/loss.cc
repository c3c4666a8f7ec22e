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

// For images of `height` rows of n floats.
struct PhotometricLoss::Layout {
  size_t n = 0;
  int height = 0;
  SsimWindow window = {};
  const float* zeros = nullptr;  // One row.
  float* scratch = nullptr;  // One block for each worker, one after the other.
  SsimDerivativeRow derivatives = {};  // The first rows of maps of all pixels.

  double count() const { return static_cast<double>(n * height); }

  // Floats of scratch rows for each worker.
  static size_t ScratchSize(size_t n) {
    return kSsimScratchRows * SsimScratchRow(n);
  }

  // The rows under the windows of the block that begins at row y of a plane.
  WindowRows RowsAround(const float* plane, int y) const {
    WindowRows rows;
    for (int k = 0; k < kSsimInputRows; ++k) {
      const int row = y + k - kSsimWindowRadius;
      rows[k] = row >= 0 && row < height ? plane + row * n : zeros;
    }
    return rows;
  }

  SsimBlock Block(int num_rows, int worker) const {
    return {window, n, num_rows, scratch + worker * ScratchSize(n)};
  }
};

PhotometricLoss::PhotometricLoss(const PhotometricLossOptions& options)
    : options_(options) {}

PhotometricLoss::Layout PhotometricLoss::LayOut(const ImageF& rendered,
                                                int num_threads) {
  const int height = rendered.height();
  const size_t n = 3 * static_cast<size_t>(rendered.width());
  const size_t plane = n * height;

  // The workspace holds a row of zeros, the scratch rows of each worker, and
  // three maps of derivatives. Of the scratch rows only the padding must be
  // zero; calls that lay the workspace out in another way overwrite it.
  const size_t head = n + Layout::ScratchSize(n) * num_threads;
  workspace_.resize(std::max(workspace_.size(), head + 3 * plane));
  if (row_size_ != n || head_ != head) {
    std::fill_n(workspace_.begin(), head, 0.0f);
    row_size_ = n;
    head_ = head;
  }
  row_l1_.resize(height);
  row_ssim_.resize(height);
  float* const maps = workspace_.data() + head;
  return {.n = n,
          .height = height,
          .window = MakeWindow(),
          .zeros = workspace_.data(),
          .scratch = workspace_.data() + n,
          .derivatives = {maps, maps + plane, maps + 2 * plane}};
}

void PhotometricLoss::Forward(const ImageF& rendered,
                              const ImageF& target,
                              const Layout& layout,
                              ThreadPool& pool) {
  const int height = layout.height;
  const SsimDerivativeRow& maps = layout.derivatives;
  pool.ParallelFor(
      0, height, kRowsPerTask, [&](int64_t first, int64_t last, int worker) {
        std::array<SsimDerivativeRow, kSsimBlockRows> derivatives;
        std::array<SsimRowSums, kSsimBlockRows> sums;
        ForEachBlock(first, last, [&](int y, int num_rows) {
          for (int r = 0; r < num_rows; ++r) {
            const size_t at = (y + r) * layout.n;
            derivatives[r] = {
                maps.mean + at, maps.square + at, maps.product + at};
          }
          SsimForwardRows(layout.RowsAround(rendered.data(), y),
                          layout.RowsAround(target.data(), y),
                          layout.Block(num_rows, worker),
                          derivatives.data(),
                          sums.data());
          for (int r = 0; r < num_rows; ++r) {
            row_l1_[y + r] = sums[r].absolute_difference;
            row_ssim_[y + r] = sums[r].ssim;
          }
        });
      });
}

void PhotometricLoss::Backward(const ImageF& rendered,
                               const ImageF& target,
                               const Layout& layout,
                               ThreadPool& pool,
                               ImageF* gradient) const {
  const int height = layout.height;
  gradient->Reshape(rendered.width(), height, 3);
  const SsimDerivativeRow& maps = layout.derivatives;
  const double weight = options_.ssim_weight;
  const LossFactors factors = {
      .l1 = static_cast<float>((1 - weight) / layout.count()),
      .ssim = static_cast<float>(-weight / layout.count())};
  pool.ParallelFor(
      0, height, kRowsPerTask, [&](int64_t first, int64_t last, int worker) {
        ForEachBlock(first, last, [&](int y, int num_rows) {
          SsimBackwardRows({layout.RowsAround(maps.mean, y),
                            layout.RowsAround(maps.square, y),
                            layout.RowsAround(maps.product, y)},
                           rendered.row(y),
                           target.row(y),
                           layout.Block(num_rows, worker),
                           factors,
                           gradient->row(y));
        });
      });
}

float PhotometricLoss::Compute(const ImageF& rendered,
                               const ImageF& target,
                               ThreadPool& pool,
                               ImageF* gradient) {
  const Layout layout = LayOut(rendered, pool.num_threads());
  Forward(rendered, target, layout, pool);
  if (gradient != nullptr) Backward(rendered, target, layout, pool, gradient);
  const double l1 =
      std::accumulate(row_l1_.begin(), row_l1_.end(), 0.0) / layout.count();
  const double ssim =
      std::accumulate(row_ssim_.begin(), row_ssim_.end(), 0.0) / layout.count();
  const double weight = options_.ssim_weight;
  return static_cast<float>((1 - weight) * l1 + weight * (1 - ssim));
}

}  // namespace freegs::splat
