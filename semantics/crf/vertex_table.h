// SPDX-License-Identifier: BSD-3-Clause
// The lattice vertices that are in use: a hash table with open addressing from
// integer coordinates to consecutive numbers.

#ifndef FREEGS_SEMANTICS_CRF_VERTEX_TABLE_H_
#define FREEGS_SEMANTICS_CRF_VERTEX_TABLE_H_

#include <cstddef>
#include <cstdint>
#include <vector>

namespace freegs::semantics {

// Vertices are numbered in the order of their first insertion. Several threads
// may call Find() at the same time, but no other method.
class VertexTable {
 public:
  static constexpr uint32_t kMissing = 0xffffffffu;

  // A key is `dim` integers; dim > 0.
  explicit VertexTable(int dim);

  size_t size() const { return keys_.size() / dim_; }
  const int32_t* Key(size_t vertex) const {
    return keys_.data() + vertex * dim_;
  }

  // Removes all vertices and keeps the memory.
  void Clear();

  // Returns the number of the vertex with this key, which is inserted if it is
  // new. There are at most 2^31 vertices. The key must not lie in the memory of
  // this table.
  uint32_t FindOrInsert(const int32_t* key);

  // Returns the number of the vertex with this key, or kMissing.
  uint32_t Find(const int32_t* key) const;

 private:
  struct Slot {
    uint32_t vertex = kMissing;
    uint32_t hash = 0;  // Spares most comparisons of keys.
  };

  uint32_t Hash(const int32_t* key) const;
  // Returns the slot of the key, or the free slot where it would go.
  size_t SlotOf(const int32_t* key, uint32_t hash) const;
  void Grow();

  int dim_;
  std::vector<int32_t> keys_;  // size() x dim.
  std::vector<Slot> slots_;    // A power of two, at most half of them taken.
};

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_CRF_VERTEX_TABLE_H_
