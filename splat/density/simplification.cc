// SPDX-License-Identifier: BSD-3-Clause

#include "splat/density/simplification.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/random.h"

namespace freegs::splat {
namespace {

bool HasImportance(float importance) {
  return importance > 0 && std::isfinite(importance);
}

// The Gaussians that have any importance, the most important first, equals by
// index.
std::vector<uint32_t> ByFallingImportance(std::span<const float> importance) {
  std::vector<uint32_t> order;
  for (size_t i = 0; i < importance.size(); ++i) {
    if (HasImportance(importance[i])) order.push_back(static_cast<uint32_t>(i));
  }
  std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
    return importance[a] > importance[b];
  });
  return order;
}

}  // namespace

std::vector<uint32_t> SampleByImportance(std::span<const float> importance,
                                         size_t count,
                                         uint64_t seed,
                                         uint64_t stream) {
  // Each Gaussian gets the waiting time of an event whose rate is its
  // importance. The `count` earliest events are a draw without replacement.
  std::vector<std::pair<double, uint32_t>> waits;
  for (size_t i = 0; i < importance.size(); ++i) {
    if (!HasImportance(importance[i])) continue;
    const double u = 1.0 - RandomUniform(seed, stream, i);  // In (0, 1].
    waits.emplace_back(-std::log(u) / importance[i], static_cast<uint32_t>(i));
  }
  if (count < waits.size()) {
    const auto end = waits.begin() + static_cast<ptrdiff_t>(count);
    std::nth_element(waits.begin(), end, waits.end());
    waits.erase(end, waits.end());
  }
  std::vector<uint32_t> drawn;
  drawn.reserve(waits.size());
  for (const auto& [wait, index] : waits) drawn.push_back(index);
  std::sort(drawn.begin(), drawn.end());
  return drawn;
}

std::vector<uint32_t> KeepCumulativeImportance(
    std::span<const float> importance, double share) {
  std::vector<uint32_t> order = ByFallingImportance(importance);
  double total = 0;
  for (const uint32_t i : order) total += importance[i];
  // A share of 1 must give all of them, whatever the rounding of the sum.
  const double wanted =
      share < 1 ? share * total : std::numeric_limits<double>::infinity();
  double carried = 0;
  size_t kept = 0;
  while (kept < order.size() && carried < wanted) {
    carried += importance[order[kept]];
    ++kept;
  }
  order.resize(kept);
  std::sort(order.begin(), order.end());
  return order;
}

std::vector<uint32_t> MostImportant(std::span<const float> importance,
                                    size_t count) {
  std::vector<uint32_t> order = ByFallingImportance(importance);
  order.resize(std::min(order.size(), count));
  std::sort(order.begin(), order.end());
  return order;
}

}  // namespace freegs::splat
