// SPDX-License-Identifier: BSD-3-Clause
// The order in which training sees the photos.

#include "splat/images/view_order.h"

#include <algorithm>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

namespace freegs::splat {
namespace {

std::vector<size_t> Epoch(ViewOrder* order, size_t num_views, int64_t epoch) {
  const auto count = static_cast<int64_t>(num_views);
  std::vector<size_t> views;
  for (int64_t k = 0; k < count; ++k) {
    views.push_back(order->ViewOf(epoch * count + k));
  }
  return views;
}

TEST(ViewOrder, EachEpochHasEachViewOnce) {
  for (const size_t num_views : {1u, 2u, 7u, 100u}) {
    ViewOrder order(3, num_views);
    for (int64_t epoch = 0; epoch < 5; ++epoch) {
      std::vector<size_t> views = Epoch(&order, num_views, epoch);
      std::sort(views.begin(), views.end());
      for (size_t k = 0; k < num_views; ++k) EXPECT_EQ(views[k], k);
    }
  }
}

TEST(ViewOrder, DependsOnSeedAndEpochOnly) {
  constexpr size_t kViews = 20;
  ViewOrder order(3, kViews);
  const std::vector<size_t> first = Epoch(&order, kViews, 0);
  const std::vector<size_t> second = Epoch(&order, kViews, 1);
  EXPECT_NE(second, first);
  EXPECT_EQ(Epoch(&order, kViews, 0), first);  // Asked for again, later.

  // A training that was interrupted begins in the middle of an epoch.
  ViewOrder resumed(3, kViews);
  EXPECT_EQ(resumed.ViewOf(kViews + 5), second[5]);
  EXPECT_EQ(Epoch(&resumed, kViews, 1), second);

  ViewOrder other(4, kViews);
  EXPECT_NE(Epoch(&other, kViews, 0), first);
}

}  // namespace
}  // namespace freegs::splat
