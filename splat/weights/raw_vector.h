// SPDX-License-Identifier: BSD-3-Clause
// A std::vector whose new numbers are not set to 0. Where all of them are
// written anyway, the zeros cost as much as what comes after: for large vectors
// the system hands out each page of memory when it is touched first, and one
// thread would touch them all.

#ifndef FREEGS_SPLAT_WEIGHTS_RAW_VECTOR_H_
#define FREEGS_SPLAT_WEIGHTS_RAW_VECTOR_H_

#include <memory>
#include <utility>
#include <vector>

namespace freegs::splat {

template <typename T>
struct RawAllocator : std::allocator<T> {
  RawAllocator() = default;
  template <typename U>
  RawAllocator(const RawAllocator<U>&) {}

  template <typename U>
  struct rebind {
    using other = RawAllocator<U>;
  };

  // What resize() calls. `new U` without parentheses leaves numbers as they
  // are.
  template <typename U>
  void construct(U* place) {
    ::new (static_cast<void*>(place)) U;
  }
  template <typename U, typename... Arguments>
  void construct(U* place, Arguments&&... arguments) {
    std::construct_at(place, std::forward<Arguments>(arguments)...);
  }
};

template <typename T>
using RawVector = std::vector<T, RawAllocator<T>>;

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_WEIGHTS_RAW_VECTOR_H_
