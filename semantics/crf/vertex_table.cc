// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/crf/vertex_table.h"

#include <algorithm>

namespace freegs::semantics {
namespace {

constexpr size_t kInitialSlots = 1024;

}  // namespace

VertexTable::VertexTable(int dim) : dim_(dim), slots_(kInitialSlots) {}

void VertexTable::Clear() {
  keys_.clear();
  std::fill(slots_.begin(), slots_.end(), Slot());
}

uint32_t VertexTable::Hash(const int32_t* key) const {
  // Neighbouring vertices differ by a few units in all coordinates, so that
  // every step has to spread all bits.
  uint64_t hash = 0;
  for (int i = 0; i < dim_; ++i) {
    hash = (hash ^ static_cast<uint32_t>(key[i])) * 0x9e3779b97f4a7c15ULL;
    hash ^= hash >> 32;
  }
  return static_cast<uint32_t>(hash);
}

size_t VertexTable::SlotOf(const int32_t* key, uint32_t hash) const {
  const size_t mask = slots_.size() - 1;
  for (size_t slot = hash & mask;; slot = (slot + 1) & mask) {
    const Slot& found = slots_[slot];
    if (found.vertex == kMissing ||
        (found.hash == hash &&
         std::equal(key, key + dim_, Key(found.vertex)))) {
      return slot;
    }
  }
}

uint32_t VertexTable::FindOrInsert(const int32_t* key) {
  const uint32_t hash = Hash(key);
  size_t slot = SlotOf(key, hash);
  if (slots_[slot].vertex != kMissing) return slots_[slot].vertex;
  const auto vertex = static_cast<uint32_t>(size());
  if (2 * (size_t{vertex} + 1) > slots_.size()) {
    Grow();
    slot = SlotOf(key, hash);
  }
  keys_.insert(keys_.end(), key, key + dim_);
  slots_[slot] = {vertex, hash};
  return vertex;
}

uint32_t VertexTable::Find(const int32_t* key) const {
  return slots_[SlotOf(key, Hash(key))].vertex;
}

void VertexTable::Grow() {
  std::vector<Slot> old(2 * slots_.size());
  old.swap(slots_);
  const size_t mask = slots_.size() - 1;
  for (const Slot& moved : old) {
    if (moved.vertex == kMissing) continue;
    size_t slot = moved.hash & mask;
    while (slots_[slot].vertex != kMissing) slot = (slot + 1) & mask;
    slots_[slot] = moved;
  }
}

}  // namespace freegs::semantics
