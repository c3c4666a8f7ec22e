// SPDX-License-Identifier: BSD-3-Clause

#include "splat/images/view_order.h"

#include <numeric>
#include <utility>

#include "core/random.h"

namespace freegs::splat {
namespace {

// Random number stream; see core/random.h.
constexpr uint64_t kViewOrderStream = 0x76696577;  // "view"

}  // namespace

size_t ViewOrder::ViewOf(int64_t iteration) {
  const auto count = static_cast<int64_t>(order_.size());
  const int64_t epoch = iteration / count;
  if (epoch != epoch_) {
    epoch_ = epoch;
    std::iota(order_.begin(), order_.end(), 0u);
    for (int64_t i = count - 1; i > 0; --i) {
      const uint64_t j = RandomIndex(seed_,
                                     kViewOrderStream,
                                     static_cast<uint64_t>(epoch * count + i),
                                     static_cast<uint64_t>(i + 1));
      std::swap(order_[i], order_[j]);
    }
  }
  return order_[iteration % count];
}

}  // namespace freegs::splat
