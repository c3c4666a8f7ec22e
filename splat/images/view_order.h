// SPDX-License-Identifier: BSD-3-Clause
// Decides which view each training step uses.

#ifndef FREEGS_SPLAT_IMAGES_VIEW_ORDER_H_
#define FREEGS_SPLAT_IMAGES_VIEW_ORDER_H_

#include <cstddef>
#include <cstdint>
#include <vector>

namespace freegs::splat {

// Each epoch uses every view once, in an order of its own. The view of an
// iteration is a function of seed and iteration, whatever was asked before, so
// a training that was interrupted goes on in the same order.
class ViewOrder {
 public:
  // num_views must be above 0.
  ViewOrder(uint64_t seed, size_t num_views) : seed_(seed), order_(num_views) {}

  // Returns the index of the view of an iteration, 0 or more.
  size_t ViewOf(int64_t iteration);

 private:
  uint64_t seed_;
  int64_t epoch_ = -1;  // The epoch whose order is in order_; -1 is none.
  std::vector<uint32_t> order_;
};

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_IMAGES_VIEW_ORDER_H_
