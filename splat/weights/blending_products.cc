// SPDX-License-Identifier: BSD-3-Clause

#include "splat/weights/blending_products.h"

#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

#include "splat/weights/blending_products_simd.h"

namespace freegs::splat {
namespace {

// The pixels of a tile share most of their Gaussians, so going through the
// image tile by tile keeps the rows of these Gaussians in the cache.
constexpr int kTile = 16;

constexpr int64_t kPixelGrain = 64;

// How many channels one task of a transposed product takes. 16 x 16 pixels
// blend a few hundred Gaussians, whose sums over so many channels fit the
// cache.
constexpr int64_t kChannelSlice = 32;

int TilesAcross(const WeightMatrix& weights) {
  return (weights.width + kTile - 1) / kTile;
}
int TilesDown(const WeightMatrix& weights) {
  return (weights.height + kTile - 1) / kTile;
}

// Calls visit(first, last) for the runs of rows of W that are a tile's pixels.
template <typename Visit>
void ForEachRun(const WeightMatrix& weights, int64_t tile, const Visit& visit) {
  const int x0 = static_cast<int>(tile % TilesAcross(weights)) * kTile;
  const int y0 = static_cast<int>(tile / TilesAcross(weights)) * kTile;
  const int x1 = std::min(x0 + kTile, weights.width);
  const int y1 = std::min(y0 + kTile, weights.height);
  for (int y = y0; y < y1; ++y) {
    const size_t row = static_cast<size_t>(y) * weights.width;
    visit(row + x0, row + x1);
  }
}

Status CheckSize(const char* what, size_t size, size_t rows, int channels) {
  if (channels > 0 && size == rows * static_cast<size_t>(channels)) {
    return Status();
  }
  return InvalidArgumentError(
      std::string(what) + " of a blending product: " + std::to_string(size) +
      " values, not " + std::to_string(rows) + " x " +
      std::to_string(channels));
}

Status CheckSizes(const WeightMatrix& weights,
                  size_t num_rows,
                  size_t gaussian_values,
                  size_t pixel_values,
                  int channels) {
  if (weights.pixel_begin.size() != weights.num_pixels() + 1 ||
      weights.gaussians.size() != weights.weights.size() ||
      weights.pixel_begin.back() != weights.weights.size()) {
    return InvalidArgumentError("the blending weights are not a whole matrix");
  }
  FREEGS_RETURN_IF_ERROR(
      CheckSize("Gaussians", gaussian_values, weights.num_gaussians, channels));
  return CheckSize("pixels", pixel_values, num_rows, channels);
}

Status CheckRows(const WeightMatrix& weights, std::span<const uint32_t> rows) {
  for (const uint32_t row : rows) {
    if (row >= weights.num_pixels()) {
      return InvalidArgumentError(
          "pixel " + std::to_string(row) + " lies outside the view's " +
          std::to_string(weights.num_pixels()) + " pixels");
    }
  }
  return Status();
}

// Calls body(first channel, last channel, worker) for all slices, on several
// threads.
template <typename Body>
void ForEachSlice(int channels, ThreadPool& pool, const Body& body) {
  pool.ParallelFor(
      0, channels, kChannelSlice, [&](int64_t first, int64_t last, int worker) {
        body(static_cast<size_t>(first), static_cast<size_t>(last), worker);
      });
}

// W in which the columns of each tile are numbered anew, 0, 1, ... in the order
// of first appearance. The sums over a tile then lie together in the cache,
// however far apart the rows of their Gaussians are. Besides, sums of sums have
// a smaller rounding error than long sums.
class TileColumns {
 public:
  TileColumns(const WeightMatrix& weights, ThreadPool& pool)
      : places_(weights.num_weights()),
        gaussians_(static_cast<size_t>(TilesAcross(weights)) *
                   TilesDown(weights)),
        matrix_(weights) {
    matrix_.gaussians = places_;
    struct Place {
      int64_t tile = -1;  // That the number is of.
      uint32_t number = 0;
    };
    std::vector<std::vector<Place>> place_of(pool.num_threads());
    pool.ParallelFor(
        0, num_tiles(), 1, [&](int64_t begin, int64_t end, int worker) {
          std::vector<Place>& places = place_of[worker];
          if (places.empty()) places.resize(weights.num_gaussians);
          for (int64_t tile = begin; tile < end; ++tile) {
            std::vector<uint32_t>& gaussians = gaussians_[tile];
            ForEachRun(weights, tile, [&](size_t first, size_t last) {
              const uint32_t run_end = weights.pixel_begin[last];
              for (uint32_t k = weights.pixel_begin[first]; k < run_end; ++k) {
                Place& place = places[weights.gaussians[k]];
                if (place.tile != tile) {
                  place = {tile, static_cast<uint32_t>(gaussians.size())};
                  gaussians.push_back(weights.gaussians[k]);
                }
                places_[k] = place.number;
              }
            });
          }
        });
  }
  TileColumns(const TileColumns&) = delete;
  TileColumns& operator=(const TileColumns&) = delete;

  int64_t num_tiles() const { return static_cast<int64_t>(gaussians_.size()); }

  // W with the tile's own numbers in the place of the Gaussians.
  const WeightMatrix& matrix() const { return matrix_; }

  // The Gaussians of a tile's numbers.
  std::span<const uint32_t> gaussians(int64_t tile) const {
    return gaussians_[tile];
  }

 private:
  std::vector<uint32_t> places_;
  std::vector<std::vector<uint32_t>> gaussians_;  // By tile.
  WeightMatrix matrix_;
};

}  // namespace

Status Multiply(const WeightMatrix& weights,
                std::span<const float> features,
                int channels,
                ThreadPool& pool,
                std::span<float> pixels) {
  FREEGS_RETURN_IF_ERROR(CheckSizes(
      weights, weights.num_pixels(), features.size(), pixels.size(), channels));
  const auto stride = static_cast<size_t>(channels);
  const int64_t tiles =
      static_cast<int64_t>(TilesAcross(weights)) * TilesDown(weights);
  pool.ParallelFor(0, tiles, 1, [&](int64_t begin, int64_t end, int) {
    for (int64_t tile = begin; tile < end; ++tile) {
      ForEachRun(weights, tile, [&](size_t first, size_t last) {
        MultiplyRows(weights,
                     first,
                     last,
                     features.data(),
                     stride,
                     pixels.data() + first * stride);
      });
    }
  });
  return Status();
}

Status MultiplyAt(const WeightMatrix& weights,
                  std::span<const uint32_t> rows,
                  std::span<const float> features,
                  int channels,
                  ThreadPool& pool,
                  std::span<float> pixels) {
  FREEGS_RETURN_IF_ERROR(CheckSizes(
      weights, rows.size(), features.size(), pixels.size(), channels));
  FREEGS_RETURN_IF_ERROR(CheckRows(weights, rows));
  const auto stride = static_cast<size_t>(channels);
  const auto count = static_cast<int64_t>(rows.size());
  pool.ParallelFor(0, count, kPixelGrain, [&](int64_t begin, int64_t end, int) {
    for (int64_t j = begin; j < end; ++j) {
      MultiplyRows(weights,
                   rows[j],
                   rows[j] + size_t{1},
                   features.data(),
                   stride,
                   pixels.data() + j * stride);
    }
  });
  return Status();
}

Status AddMultiplyTransposed(const WeightMatrix& weights,
                             std::span<const float> pixels,
                             int channels,
                             ThreadPool& pool,
                             std::span<float> sums) {
  FREEGS_RETURN_IF_ERROR(CheckSizes(
      weights, weights.num_pixels(), sums.size(), pixels.size(), channels));
  const auto stride = static_cast<size_t>(channels);
  const TileColumns columns(weights, pool);
  std::vector<std::vector<float>> tile_sums(pool.num_threads());
  ForEachSlice(channels, pool, [&](size_t c_begin, size_t c_end, int worker) {
    const size_t width = c_end - c_begin;
    for (int64_t tile = 0; tile < columns.num_tiles(); ++tile) {
      const std::span<const uint32_t> gaussians = columns.gaussians(tile);
      std::vector<float>& partial = tile_sums[worker];
      partial.assign(gaussians.size() * width, 0.0f);
      ForEachRun(weights, tile, [&](size_t first, size_t last) {
        AddTransposedRows(columns.matrix(),
                          first,
                          last,
                          pixels.data() + first * stride + c_begin,
                          stride,
                          width,
                          partial.data(),
                          width);
      });
      const float* from = partial.data();
      for (const uint32_t gaussian : gaussians) {
        float* to = sums.data() + gaussian * stride + c_begin;
        for (size_t c = 0; c < width; ++c) to[c] += *from++;
      }
    }
  });
  return Status();
}

Status AddMultiplyTransposedAt(const WeightMatrix& weights,
                               std::span<const uint32_t> rows,
                               std::span<const float> pixels,
                               int channels,
                               ThreadPool& pool,
                               std::span<float> sums) {
  FREEGS_RETURN_IF_ERROR(
      CheckSizes(weights, rows.size(), sums.size(), pixels.size(), channels));
  FREEGS_RETURN_IF_ERROR(CheckRows(weights, rows));
  const auto stride = static_cast<size_t>(channels);
  ForEachSlice(channels, pool, [&](size_t c_begin, size_t c_end, int) {
    for (size_t j = 0; j < rows.size(); ++j) {
      AddTransposedRows(weights,
                        rows[j],
                        rows[j] + size_t{1},
                        pixels.data() + j * stride + c_begin,
                        stride,
                        c_end - c_begin,
                        sums.data() + c_begin,
                        stride);
    }
  });
  return Status();
}

Status AddGaussianWeights(const WeightMatrix& weights, std::span<double> sums) {
  FREEGS_RETURN_IF_ERROR(CheckSizes(
      weights, weights.num_pixels(), sums.size(), weights.num_pixels(), 1));
  for (size_t k = 0; k < weights.num_weights(); ++k) {
    sums[weights.gaussians[k]] += weights.weights[k];
  }
  return Status();
}

}  // namespace freegs::splat
