// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/crf/permutohedral_lattice.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <type_traits>

namespace freegs::semantics {
namespace {

constexpr int64_t kVertexGrain = 2048;
constexpr int64_t kPointGrain = 2048;
constexpr int kVector = 4;  // Floats of the smallest vector of all targets.

// Calls body(c), where c is `stride` as a compile-time constant. The compiler
// turns inner loops over so many channels into vector code with sums in
// registers. stride: a multiple of kVector.
template <typename Body>
void WithStride(int stride, const Body& body) {
  static_assert(PermutohedralLattice::kMaxBlockChannels == 8 * kVector);
  switch (stride / kVector) {
    case 1:
      return body(std::integral_constant<int, kVector>());
    case 2:
      return body(std::integral_constant<int, 2 * kVector>());
    case 3:
      return body(std::integral_constant<int, 3 * kVector>());
    case 4:
      return body(std::integral_constant<int, 4 * kVector>());
    case 5:
      return body(std::integral_constant<int, 5 * kVector>());
    case 6:
      return body(std::integral_constant<int, 6 * kVector>());
    case 7:
      return body(std::integral_constant<int, 7 * kVector>());
    default:
      return body(std::integral_constant<int, 8 * kVector>());
  }
}

// out += weight * in.
template <int kStride>
inline void AddScaled(const float* __restrict in,
                      float weight,
                      float* __restrict out) {
  for (int c = 0; c < kStride; ++c) out[c] += weight * in[c];
}

}  // namespace

PermutohedralLattice::ChannelBlock PermutohedralLattice::BlockAt(int channels,
                                                                 int first) {
  const int count = std::min(kMaxBlockChannels, channels - first);
  return {channels, first, count, (count + kVector - 1) / kVector * kVector};
}

Status PermutohedralLattice::CheckValues(size_t values,
                                         size_t rows,
                                         int channels) const {
  if (channels < 1 || values % rows != 0 ||
      values / rows != static_cast<size_t>(channels)) {
    return InvalidArgumentError(std::to_string(values) + " values are not " +
                                std::to_string(rows) + " rows of " +
                                std::to_string(channels) + " channels");
  }
  return Status();
}

// Works in two steps, so that no sum is shared by threads: every chunk adds its
// points to its own slots, and then every vertex adds up its slots.
void PermutohedralLattice::SplatBlock(const float* values,
                                      const ChannelBlock& block,
                                      ThreadPool& pool,
                                      LatticeBuffers* buffers) const {
  const size_t corners = dim_ + 1;
  buffers->slots.resize(slot_vertex_.size() * block.stride);
  // The last row is zero. It stands for all missing neighbours.
  buffers->vertices.resize((num_vertices_ + 1) * block.stride);
  float* slots = buffers->slots.data();
  float* vertices = buffers->vertices.data();
  WithStride(block.stride, [&](auto stride) {
    constexpr size_t kStride = stride;
    const auto num_chunks = static_cast<int64_t>(chunk_slots_.size()) - 1;
    pool.ParallelFor(0, num_chunks, 1, [&](int64_t chunk, int64_t last, int) {
      for (; chunk < last; ++chunk) {
        std::fill(slots + chunk_slots_[chunk] * kStride,
                  slots + chunk_slots_[chunk + 1] * kStride,
                  0.0f);
        const size_t begin = chunk * kChunkPoints;
        const size_t end = std::min(num_points_, begin + kChunkPoints);
        float row[kStride] = {};
        for (size_t point = begin; point < end; ++point) {
          std::copy_n(
              values + point * block.channels + block.first, block.count, row);
          for (size_t entry = point * corners; entry < (point + 1) * corners;
               ++entry) {
            AddScaled<kStride>(row,
                               point_weights_[entry],
                               slots + point_slots_[entry] * kStride);
          }
        }
      }
    });
    const auto num_vertices = static_cast<int64_t>(num_vertices_);
    pool.ParallelFor(
        0, num_vertices, kVertexGrain, [&](int64_t v, int64_t last, int) {
          for (; v < last; ++v) {
            float sum[kStride] = {};
            for (uint32_t k = vertex_begin_[v]; k < vertex_begin_[v + 1]; ++k) {
              AddScaled<kStride>(slots + vertex_slots_[k] * kStride, 1, sum);
            }
            std::copy_n(sum, kStride, vertices + v * kStride);
          }
        });
    std::fill_n(vertices + num_vertices * kStride, kStride, 0.0f);
  });
}

void PermutohedralLattice::BlurBlock(const ChannelBlock& block,
                                     ThreadPool& pool,
                                     LatticeBuffers* buffers) const {
  const auto num_vertices = static_cast<int64_t>(num_vertices_);
  buffers->blurred.resize(buffers->vertices.size());
  std::fill_n(buffers->blurred.end() - block.stride, block.stride, 0.0f);
  for (int axis = 0; axis <= dim_; ++axis) {
    const NeighborPair* pairs = neighbors_.data() + axis * num_vertices_;
    const float* from = buffers->vertices.data();
    float* to = buffers->blurred.data();
    WithStride(block.stride, [&](auto stride) {
      constexpr size_t kStride = stride;
      pool.ParallelFor(
          0, num_vertices, kVertexGrain, [&](int64_t v, int64_t last, int) {
            for (; v < last; ++v) {
              const float* own = from + v * kStride;
              const float* before = from + pairs[v].before * kStride;
              const float* after = from + pairs[v].after * kStride;
              float* __restrict out = to + v * kStride;
              for (size_t c = 0; c < kStride; ++c) {
                out[c] = 0.5f * own[c] + 0.25f * (before[c] + after[c]);
              }
            }
          });
    });
    buffers->vertices.swap(buffers->blurred);
  }
}

void PermutohedralLattice::SliceBlock(const LatticeBuffers& buffers,
                                      const ChannelBlock& block,
                                      float gain,
                                      ThreadPool& pool,
                                      float* result) const {
  const size_t corners = dim_ + 1;
  const float* vertices = buffers.vertices.data();
  WithStride(block.stride, [&](auto stride) {
    constexpr size_t kStride = stride;
    const auto num_points = static_cast<int64_t>(num_points_);
    pool.ParallelFor(
        0, num_points, kPointGrain, [&](int64_t point, int64_t last, int) {
          for (; point < last; ++point) {
            float sum[kStride] = {};
            for (size_t entry = point * corners; entry < (point + 1) * corners;
                 ++entry) {
              AddScaled<kStride>(
                  vertices + slot_vertex_[point_slots_[entry]] * kStride,
                  point_weights_[entry],
                  sum);
            }
            float* row = result + point * block.channels + block.first;
            for (int c = 0; c < block.count; ++c) row[c] += gain * sum[c];
          }
        });
  });
}

Status PermutohedralLattice::AddFiltered(std::span<const float> values,
                                         int channels,
                                         float gain,
                                         ThreadPool& pool,
                                         LatticeBuffers* buffers,
                                         std::span<float> result) const {
  FREEGS_RETURN_IF_ERROR(CheckValues(values.size(), num_points_, channels));
  FREEGS_RETURN_IF_ERROR(CheckValues(result.size(), num_points_, channels));
  for (int first = 0; first < channels; first += kMaxBlockChannels) {
    const ChannelBlock block = BlockAt(channels, first);
    SplatBlock(values.data(), block, pool, buffers);
    BlurBlock(block, pool, buffers);
    SliceBlock(*buffers, block, gain * kernel_scale_, pool, result.data());
  }
  return Status();
}

void PermutohedralLattice::NormalizeSymmetrically(ThreadPool& pool) {
  const std::vector<float> ones(num_points_, 1.0f);
  std::vector<float> sums(num_points_, 0.0f);
  const ChannelBlock block = BlockAt(1, 0);
  LatticeBuffers buffers;
  SplatBlock(ones.data(), block, pool, &buffers);
  BlurBlock(block, pool, &buffers);
  SliceBlock(buffers, block, kernel_scale_, pool, sums.data());
  // Sums are never zero, because every point is its own neighbour.
  const size_t corners = dim_ + 1;
  const auto num_points = static_cast<int64_t>(num_points_);
  pool.ParallelFor(
      0, num_points, kPointGrain, [&](int64_t point, int64_t last, int) {
        for (; point < last; ++point) {
          const float root = std::sqrt(sums[point]);
          for (size_t k = 0; k < corners; ++k) {
            point_weights_[point * corners + k] /= root;
          }
        }
      });
}

double PermutohedralLattice::SelfResponse(size_t point) const {
  // Vertices of successive remainders are neighbours along an axis; so are the
  // last and the first. Counted are the paths from such a vertex to itself or
  // to its neighbour. Each of the d + 1 blurs halves what stays on a vertex.
  const float* weights = point_weights_.data() + point * (dim_ + 1);
  double sum = 0;
  for (int k = 0; k <= dim_; ++k) {
    const int next = k == dim_ ? 0 : k + 1;
    sum += double{weights[k]} * (double{weights[k]} + weights[next]);
  }
  return std::ldexp(sum, -(dim_ + 1)) * kernel_scale_;
}

}  // namespace freegs::semantics
