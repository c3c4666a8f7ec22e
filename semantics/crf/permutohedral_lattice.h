// SPDX-License-Identifier: BSD-3-Clause
// Gaussian filtering of values at points of several dimensions, such as pixels
// with position and colour, in time linear in the number of points (Adams, Baek
// and Davis, "Fast High-Dimensional Filtering Using the Permutohedral Lattice",
// Eurographics 2010).

#ifndef FREEGS_SEMANTICS_CRF_PERMUTOHEDRAL_LATTICE_H_
#define FREEGS_SEMANTICS_CRF_PERMUTOHEDRAL_LATTICE_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/parallel.h"
#include "core/status.h"

namespace freegs::semantics {

// Memory that filtering works in; one to keep from call to call per thread that
// calls.
struct LatticeBuffers {
  std::vector<float> slots;
  std::vector<float> vertices;
  std::vector<float> blurred;
};

// K v with K_ij = exp(-|f_i - f_j|^2 / 2), about: values are splatted onto the
// vertices of the simplex around each point, blurred over the lattice, and
// sliced at the points again. Errors are in docs/crf.md.
//
// Built once for some features, it filters any number of values. The result is
// a function of the input only, whatever the number of threads: vertices are
// numbered by their first use in order of points, and every sum has a fixed
// order.
//
// Memory, with N points of dimension d, M <= S <= N (d + 1) vertices in use and
// S <= N (d + 1) slots, which are vertices counted once per kChunkPoints
// points: 8 N (d + 1) + 8 M (d + 1) + 8 S + 4 M bytes, while built 4 d (2 M +
// S) + 32 M more. Filtering takes 4 (S + 2 M) bytes for each of at most
// kMaxBlockChannels channels at a time. M is far below N (d + 1) where many
// points are within a standard deviation of each other.
class PermutohedralLattice {
 public:
  // Points of one chunk are splatted by one thread, one after another.
  static constexpr size_t kChunkPoints = 4096;
  static constexpr int kMaxBlockChannels = 32;

  // features: N x dim, row-major, in standard deviations of the Gaussian.
  // Points that are near each other should follow each other, as pixels do in
  // rows. kInvalidArgument when dim is outside 1 .. 16, the size is not a
  // multiple of dim or zero, N (dim + 1) exceeds 2^31 - 1, or a feature is not
  // finite or larger than 1e6.
  static StatusOr<PermutohedralLattice> Build(std::span<const float> features,
                                              int dim,
                                              ThreadPool& pool);

  int dim() const { return dim_; }
  size_t num_points() const { return num_points_; }
  size_t num_vertices() const { return num_vertices_; }

  // *result += gain * K values. values and *result: N x channels, row-major;
  // not the same memory. kInvalidArgument for other sizes and no channels.
  Status AddFiltered(std::span<const float> values,
                     int channels,
                     float gain,
                     ThreadPool& pool,
                     LatticeBuffers* buffers,
                     std::span<float> result) const;

  // Makes the filter D^(-1/2) K D^(-1/2) with D the diagonal of K 1 (sums over
  // all points, the point itself included): the symmetric normalisation of
  // Kraehenbuehl and Koltun, "Parameter Learning and Convergent Inference for
  // Dense Random Fields", 2013. Splat and Slice then carry D^(-1/2) too. Once.
  void NormalizeSymmetrically(ThreadPool& pool);

  // What a point surely gets of its own value, K_ii from below: without paths
  // over vertices other than those around it, which may be missing. Times D^-1
  // after normalisation.
  double SelfResponse(size_t point) const;

 private:
  // Channels [first, first + count) of rows of `channels`; rows of `stride` in
  // the buffers, a multiple of four, so that inner loops are whole vectors.
  struct ChannelBlock {
    int channels;
    int first;
    int count;
    int stride;
  };

  PermutohedralLattice() = default;

  static ChannelBlock BlockAt(int channels, int first);
  Status CheckValues(size_t values, size_t rows, int channels) const;
  void SplatBlock(const float* values,
                  const ChannelBlock& block,
                  ThreadPool& pool,
                  LatticeBuffers* buffers) const;
  void BlurBlock(const ChannelBlock& block,
                 ThreadPool& pool,
                 LatticeBuffers* buffers) const;
  void SliceBlock(const LatticeBuffers& buffers,
                  const ChannelBlock& block,
                  float gain,
                  ThreadPool& pool,
                  float* result) const;

  struct Builder;

  // Both neighbours of a vertex along an axis; num_vertices_ where missing.
  struct NeighborPair {
    uint32_t before;
    uint32_t after;
  };

  int dim_ = 0;
  size_t num_points_ = 0;
  size_t num_vertices_ = 0;
  float kernel_scale_ = 1;  // Makes the peak of the kernel one.

  // N x (d + 1): the vertices around each point, in order of remainder, as
  // slots, and their barycentric weights.
  std::vector<uint32_t> point_slots_;
  std::vector<float> point_weights_;
  // A slot is a vertex as one chunk of points sees it. Slots of a chunk are
  // [chunk_slots_[c], chunk_slots_[c + 1]); every slot has a vertex, and every
  // vertex v the slots vertex_slots_[vertex_begin_[v] .. [v + 1]), ascending.
  std::vector<uint32_t> chunk_slots_;
  std::vector<uint32_t> slot_vertex_;
  std::vector<uint32_t> vertex_begin_;
  std::vector<uint32_t> vertex_slots_;
  std::vector<NeighborPair> neighbors_;  // (d + 1) x num_vertices_.
};

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_CRF_PERMUTOHEDRAL_LATTICE_H_
