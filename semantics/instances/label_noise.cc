// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/instances/label_noise.h"

#include <cmath>

#include "core/kd_tree.h"

namespace freegs::semantics {

void LabelNoise(std::span<const float> positions,
                double distance,
                ThreadPool& pool,
                std::vector<int32_t>* labels) {
  std::vector<uint32_t> labelled;
  std::vector<float> labelled_positions;
  for (size_t i = 0; i < labels->size(); ++i) {
    if ((*labels)[i] < 0) continue;
    labelled.push_back(static_cast<uint32_t>(i));
    labelled_positions.insert(labelled_positions.end(),
                              positions.begin() + i * 3,
                              positions.begin() + i * 3 + 3);
  }
  const auto tree = KdTree::Build(labelled_positions, 3);
  if (labelled.empty() || !tree.ok()) return;
  pool.ParallelFor(
      0, labels->size(), 512, [&](int64_t first, int64_t last, int) {
        std::vector<Neighbor> nearest;
        for (int64_t i = first; i < last; ++i) {
          // No race: threads write labels of points that had -1, and read
          // labels of points that had another.
          if ((*labels)[i] >= 0) continue;
          tree->Nearest(positions.data() + i * 3, 1, KdTree::kNoRow, &nearest);
          if (nearest[0].distance2 <= distance * distance) {
            (*labels)[i] = (*labels)[labelled[nearest[0].index]];
          }
        }
      });
}

void LabelNoise(const splat::GaussianModel& model,
                double distance,
                ThreadPool& pool,
                std::vector<int32_t>* labels) {
  std::vector<float> positions = model.means;
  for (float& x : positions) {
    if (!(std::abs(x) <= KdTree::kMaxCoordinate)) x = KdTree::kMaxCoordinate;
  }
  LabelNoise(positions, distance, pool, labels);
}

}  // namespace freegs::semantics
