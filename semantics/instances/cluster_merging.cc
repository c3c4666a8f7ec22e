// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/instances/cluster_merging.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include <Eigen/Core>

#include "core/disjoint_sets.h"
#include "core/kd_tree.h"

namespace freegs::semantics {
namespace {

constexpr double kTouchingShare = 0.005;
// Neighbours looked at to find other clusters nearby.
constexpr int kNumNeighbors = 24;

}  // namespace

void MergeClusters(std::span<const float> positions,
                   std::span<const float> colors,
                   double distance,
                   double color_difference,
                   ThreadPool& pool,
                   std::vector<int32_t>* labels) {
  const size_t count = labels->size();
  int32_t num_labels = 0;
  for (const int32_t label : *labels)
    num_labels = std::max(num_labels, label + 1);
  if (num_labels < 2) return;
  std::vector<Eigen::Vector3d> mean(num_labels, Eigen::Vector3d::Zero());
  std::vector<size_t> size(num_labels, 0);
  std::vector<uint32_t> labelled;
  std::vector<float> labelled_positions;
  for (size_t i = 0; i < count; ++i) {
    const int32_t label = (*labels)[i];
    if (label < 0) continue;
    mean[label] +=
        Eigen::Vector3d(colors[i * 3], colors[i * 3 + 1], colors[i * 3 + 2]);
    ++size[label];
    labelled.push_back(static_cast<uint32_t>(i));
    labelled_positions.insert(labelled_positions.end(),
                              positions.begin() + i * 3,
                              positions.begin() + i * 3 + 3);
  }
  for (int32_t c = 0; c < num_labels; ++c) {
    if (size[c] > 0) mean[c] /= static_cast<double>(size[c]);
  }
  const auto tree = KdTree::Build(labelled_positions, 3);
  if (!tree.ok()) return;

  // For each labelled point, the other labels within reach.
  std::vector<std::vector<int32_t>> touched(labelled.size());
  pool.ParallelFor(
      0, labelled.size(), 512, [&](int64_t first, int64_t last, int) {
        std::vector<Neighbor> neighbors;
        for (int64_t i = first; i < last; ++i) {
          tree->Nearest(labelled_positions.data() + i * 3,
                        kNumNeighbors,
                        static_cast<uint32_t>(i),
                        &neighbors);
          const int32_t own = (*labels)[labelled[i]];
          for (const Neighbor& neighbor : neighbors) {
            if (neighbor.distance2 > distance * distance) break;
            const int32_t other = (*labels)[labelled[neighbor.index]];
            if (other != own &&
                std::find(touched[i].begin(), touched[i].end(), other) ==
                    touched[i].end()) {
              touched[i].push_back(other);
            }
          }
        }
      });
  std::map<std::pair<int32_t, int32_t>, size_t> contacts;  // (own, other).
  for (size_t i = 0; i < labelled.size(); ++i) {
    for (const int32_t other : touched[i]) {
      ++contacts[{(*labels)[labelled[i]], other}];
    }
  }
  DisjointSets merged(num_labels);
  for (const auto& [pair, contact] : contacts) {
    const auto [own, other] = pair;
    if (size[own] > size[other]) continue;
    if (static_cast<double>(contact) <
            kTouchingShare * static_cast<double>(size[own]) ||
        (mean[own] - mean[other]).norm() >= color_difference) {
      continue;
    }
    merged.Join(own, other);
  }
  for (int32_t& label : *labels) {
    if (label >= 0) label = static_cast<int32_t>(merged.Find(label));
  }
}

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

}  // namespace freegs::semantics
