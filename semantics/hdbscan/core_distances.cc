// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/hdbscan/core_distances.h"

#include <algorithm>
#include <limits>

namespace freegs::semantics {

StatusOr<CoreDistances> ComputeCoreDistances(
    const KdTree& tree,
    int min_samples,
    ThreadPool& pool,
    const CancellationToken* cancellation) {
  if (min_samples < 1) {
    return InvalidArgumentError("min_samples must be at least 1");
  }
  const auto count = static_cast<int64_t>(tree.size());
  CoreDistances result;
  result.core2.assign(count, 0.0);
  result.last2.assign(count, std::numeric_limits<double>::infinity());
  if (count < 2) return result;
  const int64_t k = std::min<int64_t>(min_samples, count - 1);
  // The list has one neighbour more than asked, because no point outside of the
  // list is nearer than its last point.
  const int64_t list_size = std::min<int64_t>(k + 1, count - 1);
  result.list_size = static_cast<int>(list_size);
  result.neighbors.resize(count * list_size);

  std::vector<uint32_t> position_of_row(count);
  for (int64_t position = 0; position < count; ++position) {
    position_of_row[tree.Row(position)] = static_cast<uint32_t>(position);
  }
  pool.ParallelFor(0, count, 256, [&](int64_t first, int64_t last, int) {
    if (IsCancelled(cancellation)) return;
    std::vector<Neighbor> found;
    for (int64_t position = first; position < last; ++position) {
      tree.Nearest(tree.Point(position),
                   static_cast<int>(list_size),
                   tree.Row(position),
                   &found);
      uint32_t* list = result.neighbors.data() + position * list_size;
      for (int64_t j = 0; j < list_size; ++j) {
        list[j] = position_of_row[found[j].index];
      }
      result.core2[position] = found[k - 1].distance2;
      if (list_size < count - 1) {
        result.last2[position] = found[list_size - 1].distance2;
      }
    }
  });
  if (IsCancelled(cancellation)) {
    return InterruptedError("clustering was interrupted");
  }
  return result;
}

}  // namespace freegs::semantics
