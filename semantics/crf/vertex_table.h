// SPDX-License-Identifier: BSD-3-Clause
// The lattice vertices that are in use: a hash table with open addressing from
// integer coordinates to consecutive numbers.

#ifndef FREEGS_SEMANTICS_CRF_VERTEX_TABLE_H_
#define FREEGS_SEMANTICS_CRF_VERTEX_TABLE_H_

#include <cstddef>
#include <cstdint>
#include <vector>

namespace freegs::semantics {

// Vertices are numbered in the order of their first insertion: a function of
// the sequence of insertions only. Not for several threads at once, but for
// Find.
class VertexTable {
 public:
  static constexpr uint32_t kMissing = 0xffffffffu;

  // Keys are `dim` integers; dim > 0.
  explicit VertexTable(int dim);

  size_t size() const { return keys_.size() / dim_; }
  const int32_t* Key(size_t vertex) const {
    return keys_.data() + vertex * dim_;
  }

  // Forgets the vertices, keeps the memory.
  void Clear();

  // The number of the vertex with this key, a new one if need be. At most
  // 2^31 vertices. The key must not lie within this table.
  uint32_t FindOrInsert(const int32_t* key);

  // The same, or kMissing.
  uint32_t Find(const int32_t* key) const;

 private:
  struct Slot {
    uint32_t vertex = kMissing;
    uint32_t hash = 0;  // Spares most comparisons of keys, and growing any.
  };

  uint32_t Hash(const int32_t* key) const;
  // Where the key is, or the free slot where it would go.
  size_t SlotOf(const int32_t* key, uint32_t hash) const;
  void Grow();

  int dim_;
  std::vector<int32_t> keys_;  // size() x dim.
  std::vector<Slot> slots_;    // A power of two, at most half of them taken.
};

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_CRF_VERTEX_TABLE_H_
