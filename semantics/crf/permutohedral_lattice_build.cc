// SPDX-License-Identifier: BSD-3-Clause
// How the lattice of some features is built: see permutohedral_lattice.h.

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <utility>

#include "semantics/crf/enclosing_simplex.h"
#include "semantics/crf/permutohedral_lattice.h"
#include "semantics/crf/vertex_table.h"

namespace freegs::semantics {
namespace {

constexpr int64_t kBuildGrain = 2048;

Status CheckFeatures(std::span<const float> features, int dim) {
  if (dim < 1 || dim > kMaxLatticeDim) {
    return InvalidArgumentError("a lattice needs 1 .. " +
                                std::to_string(kMaxLatticeDim) +
                                " dimensions, not " + std::to_string(dim));
  }
  if (features.empty() || features.size() % dim != 0) {
    return InvalidArgumentError(std::to_string(features.size()) +
                                " values are not points of " +
                                std::to_string(dim) + " dimensions");
  }
  const size_t points = features.size() / dim;
  if (points > std::numeric_limits<int32_t>::max() / (size_t{1} + dim)) {
    return InvalidArgumentError(
        std::to_string(points) + " points are too many for a lattice of " +
        std::to_string(dim) + " dimensions; use a smaller image");
  }
  for (const float feature : features) {
    if (!(std::abs(feature) <= kMaxLatticeFeature)) {
      return InvalidArgumentError(
          "features must be finite and at most 1e6 standard deviations; use a "
          "larger one");
    }
  }
  return Status();
}

}  // namespace

struct PermutohedralLattice::Builder {
  Builder(std::span<const float> features, int dim)
      : features(features),
        dim(dim),
        num_chunks((features.size() / dim + kChunkPoints - 1) / kChunkPoints),
        chunk_keys(num_chunks),
        locator(dim) {}

  // The simplex around each point of a chunk. Its slots are the chunk's own
  // vertices, numbered from zero for now; `table` is working memory.
  void LocateChunk(size_t chunk,
                   VertexTable& table,
                   PermutohedralLattice* lattice) {
    table.Clear();
    const size_t begin = chunk * kChunkPoints;
    const size_t end = std::min(lattice->num_points_, begin + kChunkPoints);
    EnclosingSimplex simplices[2];
    for (size_t point = begin; point < end; ++point) {
      EnclosingSimplex& simplex = simplices[point % 2];
      locator.Locate(features.data() + point * dim, &simplex);
      const size_t entry = point * (dim + 1);
      uint32_t* slots = lattice->point_slots_.data() + entry;
      // Neighbouring pixels are often in the same simplex.
      if (point > begin && SameSimplex(simplices[0], simplices[1])) {
        std::copy(slots - (dim + 1), slots, slots);
      } else {
        int32_t key[kMaxLatticeDim] = {};
        for (int k = 0; k <= dim; ++k) {
          simplex.VertexKey(dim, k, key);
          slots[k] = table.FindOrInsert(key);
        }
      }
      for (int k = 0; k <= dim; ++k) {
        lattice->point_weights_[entry + k] =
            static_cast<float>(simplex.weights[k]);
      }
    }
    chunk_keys[chunk].assign(table.Key(0), table.Key(0) + table.size() * dim);
  }

  bool SameSimplex(const EnclosingSimplex& a, const EnclosingSimplex& b) const {
    const auto same = [this](const auto& x, const auto& y) {
      return std::equal(x.begin(), x.begin() + dim + 1, y.begin());
    };
    return same(a.origin, b.origin) && same(a.rank, b.rank);
  }

  // Vertices get numbers by first use, because chunks number theirs so too.
  void MergeChunks(VertexTable& table, PermutohedralLattice* lattice) {
    lattice->chunk_slots_.assign(1, 0);
    size_t num_slots = 0;
    for (const auto& keys : chunk_keys) num_slots += keys.size() / dim;
    lattice->slot_vertex_.reserve(num_slots);
    for (std::vector<int32_t>& keys : chunk_keys) {
      for (size_t k = 0; k < keys.size(); k += dim) {
        lattice->slot_vertex_.push_back(table.FindOrInsert(keys.data() + k));
      }
      lattice->chunk_slots_.push_back(
          static_cast<uint32_t>(lattice->slot_vertex_.size()));
      std::vector<int32_t>().swap(keys);
    }
    lattice->num_vertices_ = table.size();
  }

  std::span<const float> features;
  int dim;
  size_t num_chunks;
  std::vector<std::vector<int32_t>> chunk_keys;
  SimplexLocator locator;
};

StatusOr<PermutohedralLattice> PermutohedralLattice::Build(
    std::span<const float> features, int dim, ThreadPool& pool) {
  FREEGS_RETURN_IF_ERROR(CheckFeatures(features, dim));
  PermutohedralLattice lattice;
  lattice.dim_ = dim;
  lattice.num_points_ = features.size() / dim;
  // The blur keeps sums; a Gaussian of height one has the sum (2 pi)^(d/2)
  // times the density of vertices. There is one in (d + 1)^(d - 1/2) of the
  // hyperplane, whose unit is 1 / (sqrt(2/3) (d + 1)) standard deviations.
  lattice.kernel_scale_ = static_cast<float>(
      std::pow(4 * std::numbers::pi / 3, dim / 2.0) * std::sqrt(dim + 1.0));

  const size_t entries = lattice.num_points_ * (dim + 1);
  lattice.point_slots_.resize(entries);
  lattice.point_weights_.resize(entries);
  Builder builder(features, dim);
  std::vector<VertexTable> tables(pool.num_threads(), VertexTable(dim));
  pool.ParallelFor(0,
                   static_cast<int64_t>(builder.num_chunks),
                   1,
                   [&](int64_t first, int64_t last, int worker) {
                     for (int64_t chunk = first; chunk < last; ++chunk) {
                       builder.LocateChunk(chunk, tables[worker], &lattice);
                     }
                   });
  VertexTable table(dim);
  builder.MergeChunks(table, &lattice);
  pool.ParallelFor(0,
                   static_cast<int64_t>(builder.num_chunks),
                   1,
                   [&](int64_t first, int64_t last, int) {
                     for (int64_t chunk = first; chunk < last; ++chunk) {
                       const size_t begin = chunk * kChunkPoints * (dim + 1);
                       const size_t end =
                           std::min(entries, begin + kChunkPoints * (dim + 1));
                       for (size_t entry = begin; entry < end; ++entry) {
                         lattice.point_slots_[entry] +=
                             lattice.chunk_slots_[chunk];
                       }
                     }
                   });

  // Sort the slots by vertex, by counting.
  const size_t vertices = lattice.num_vertices_;
  std::vector<uint32_t>& begins = lattice.vertex_begin_;
  begins.assign(vertices + 2, 0);
  for (const uint32_t vertex : lattice.slot_vertex_) ++begins[vertex + 2];
  for (size_t v = 2; v < begins.size(); ++v) begins[v] += begins[v - 1];
  lattice.vertex_slots_.resize(lattice.slot_vertex_.size());
  for (size_t slot = 0; slot < lattice.slot_vertex_.size(); ++slot) {
    lattice.vertex_slots_[begins[lattice.slot_vertex_[slot] + 1]++] =
        static_cast<uint32_t>(slot);
  }
  begins.pop_back();

  // A vertex has one predecessor along an axis, so that no two threads write
  // the same value.
  const auto missing = static_cast<uint32_t>(vertices);
  lattice.neighbors_.assign(vertices * (dim + 1), {missing, missing});
  pool.ParallelFor(0,
                   static_cast<int64_t>(vertices),
                   kBuildGrain,
                   [&](int64_t first, int64_t last, int) {
                     int32_t key[kMaxLatticeDim] = {};
                     for (int64_t v = first; v < last; ++v) {
                       for (int axis = 0; axis <= dim; ++axis) {
                         const int32_t* own = table.Key(v);
                         for (int i = 0; i < dim; ++i) key[i] = own[i] + 1;
                         if (axis < dim) key[axis] -= dim + 1;
                         const uint32_t after = table.Find(key);
                         if (after == VertexTable::kMissing) continue;
                         NeighborPair* pairs =
                             lattice.neighbors_.data() + axis * vertices;
                         pairs[v].after = after;
                         pairs[after].before = static_cast<uint32_t>(v);
                       }
                     }
                   });
  return lattice;
}

}  // namespace freegs::semantics
