// SPDX-License-Identifier: BSD-3-Clause
// Which view a training step shows.

#ifndef FREEGS_SPLAT_IMAGES_VIEW_ORDER_H_
#define FREEGS_SPLAT_IMAGES_VIEW_ORDER_H_

#include <cstddef>
#include <cstdint>
#include <vector>

namespace freegs::splat {

// Each epoch shows every view once, in an order of its own: a function of seed
// and iteration, whatever was asked before.
class ViewOrder {
 public:
  // num_views > 0.
  ViewOrder(uint64_t seed, size_t num_views) : seed_(seed), order_(num_views) {}

  // iteration >= 0.
  size_t ViewOf(int64_t iteration);

 private:
  uint64_t seed_;
  int64_t epoch_ = -1;  // That order_ holds.
  std::vector<uint32_t> order_;
};

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_IMAGES_VIEW_ORDER_H_
