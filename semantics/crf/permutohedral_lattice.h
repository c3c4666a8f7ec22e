// SPDX-License-Identifier: BSD-3-Clause
// Gaussian filtering of values at points of several dimensions, for example at
// pixels with position and colour. The time is linear in the number of points
// (Adams, Baek and Davis, "Fast High-Dimensional Filtering Using the
// Permutohedral Lattice", Eurographics 2010).

#ifndef FREEGS_SEMANTICS_CRF_PERMUTOHEDRAL_LATTICE_H_
#define FREEGS_SEMANTICS_CRF_PERMUTOHEDRAL_LATTICE_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/parallel.h"
#include "core/status.h"

namespace freegs::semantics {

// The memory that filtering works in. A thread that filters many times keeps
// one of these from call to call.
struct LatticeBuffers {
  std::vector<float> slots;
  std::vector<float> vertices;
  std::vector<float> blurred;
};

// Computes about K v with K_ij = exp(-|f_i - f_j|^2 / 2). Values are splatted
// onto the vertices of the simplex around each point, blurred over the lattice,
// and sliced at the points again. docs/crf.md has the measured errors.
//
// A lattice is built once for some features and filters any number of values.
// The result does not depend on the number of threads: vertices are numbered by
// their first use in the order of points, and every sum has a fixed order.
//
// Memory: let there be N points of dimension d. M is the number of vertices in
// use, and S is the number of slots, where each chunk of kChunkPoints points
// has its own slots for its vertices; M <= S <= N (d + 1). The lattice takes 8
// N (d + 1) + 8 M (d + 1) + 8 S + 4 M bytes, and 4 d (2 M + S) + 32 M bytes
// more while it is built. Filtering takes 4 (S + 2 M) bytes for each of at most
// kMaxBlockChannels channels at a time. M is far below N (d + 1) if many points
// are within a standard deviation of each other.
class PermutohedralLattice {
 public:
  // The points of a chunk are splatted by one thread, one after another.
  static constexpr size_t kChunkPoints = 4096;
  static constexpr int kMaxBlockChannels = 32;

  // features: N x dim, row-major, in standard deviations of the Gaussian.
  // Points that are near each other should follow each other, as the pixels of
  // a row do. kInvalidArgument if dim is outside 1 .. 16, the size is zero or
  // no multiple of dim, N (dim + 1) exceeds 2^31 - 1, or a feature is not
  // finite or larger than 1e6.
  static StatusOr<PermutohedralLattice> Build(std::span<const float> features,
                                              int dim,
                                              ThreadPool& pool);

  int dim() const { return dim_; }
  size_t num_points() const { return num_points_; }
  size_t num_vertices() const { return num_vertices_; }

  // Adds gain * K values to `result`. values, result: N x channels, row-major,
  // not the same memory. kInvalidArgument for other sizes and for no channels.
  Status AddFiltered(std::span<const float> values,
                     int channels,
                     float gain,
                     ThreadPool& pool,
                     LatticeBuffers* buffers,
                     std::span<float> result) const;

  // Turns the filter into D^(-1/2) K D^(-1/2), where D is the diagonal matrix
  // of the sums K 1 over all points, the point itself included. This is the
  // symmetric normalisation of Kraehenbuehl and Koltun, "Parameter Learning and
  // Convergent Inference for Dense Random Fields", 2013. Call it once at most.
  void NormalizeSymmetrically(ThreadPool& pool);

  // Returns a lower bound of K_ii, the share of its own value that a point
  // surely gets back. Paths over vertices that are not around the point are
  // left out, because such vertices may not exist. After normalisation the
  // bound is that of K_ii / D_i.
  double SelfResponse(size_t point) const;

 private:
  // Channels [first, first + count) of rows of `channels`. In the buffers a row
  // has `stride` numbers, a multiple of four, so that inner loops work on whole
  // vectors.
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

  // The neighbours of a vertex along an axis; num_vertices_ if there is none.
  struct NeighborPair {
    uint32_t before;
    uint32_t after;
  };

  int dim_ = 0;
  size_t num_points_ = 0;
  size_t num_vertices_ = 0;
  float kernel_scale_ = 1;  // Makes the peak of the kernel one.

  // N x (d + 1): the slots of the vertices around each point, in order of
  // remainder, and their barycentric weights.
  std::vector<uint32_t> point_slots_;
  std::vector<float> point_weights_;
  // A slot is a vertex as one chunk of points sees it. Chunk c has the slots
  // chunk_slots_[c] .. chunk_slots_[c + 1] - 1. Slot s belongs to vertex
  // slot_vertex_[s]. Vertex v has the slots vertex_slots_[k], ascending, for k
  // from vertex_begin_[v] to vertex_begin_[v + 1] - 1.
  std::vector<uint32_t> chunk_slots_;
  std::vector<uint32_t> slot_vertex_;
  std::vector<uint32_t> vertex_begin_;
  std::vector<uint32_t> vertex_slots_;
  std::vector<NeighborPair> neighbors_;  // (d + 1) x num_vertices_.
};

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_CRF_PERMUTOHEDRAL_LATTICE_H_
