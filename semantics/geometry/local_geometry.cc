// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/geometry/local_geometry.h"

#include <algorithm>
#include <functional>

#include <Eigen/Core>

#include "core/decompositions.h"

namespace freegs::semantics {
namespace {

// Calls body(row, neighbours) for all points; neighbours do not hold the point.
void ForEachNeighborhood(
    const KdTree& tree,
    int num_neighbors,
    ThreadPool& pool,
    const std::function<void(uint32_t, const std::vector<Neighbor>&)>& body) {
  pool.ParallelFor(0, tree.size(), 512, [&](int64_t first, int64_t last, int) {
    std::vector<Neighbor> neighbors;
    for (int64_t position = first; position < last; ++position) {
      const auto p = static_cast<uint32_t>(position);
      tree.Nearest(tree.Point(p), num_neighbors, tree.Row(p), &neighbors);
      body(tree.Row(p), neighbors);
    }
  });
}

// Coordinates in the order of rows, because neighbours are given as rows.
std::vector<float> RowsOf(const KdTree& tree) {
  std::vector<float> rows(tree.size() * tree.dim());
  for (uint32_t p = 0; p < tree.size(); ++p) {
    std::copy_n(tree.Point(p),
                tree.dim(),
                rows.data() + static_cast<size_t>(tree.Row(p)) * tree.dim());
  }
  return rows;
}

}  // namespace

std::vector<float> ComputeNormals(const KdTree& tree,
                                  int num_neighbors,
                                  ThreadPool& pool) {
  const std::vector<float> points = RowsOf(tree);
  const auto point = [&](uint32_t row) {
    return Eigen::Vector3d(
        points[row * 3], points[row * 3 + 1], points[row * 3 + 2]);
  };
  std::vector<float> normals(tree.size() * 3);
  ForEachNeighborhood(
      tree,
      num_neighbors,
      pool,
      [&](uint32_t row, const std::vector<Neighbor>& neighbors) {
        const Eigen::Vector3d center = point(row);
        Eigen::Vector3d mean = Eigen::Vector3d::Zero();
        Eigen::Matrix3d moment = Eigen::Matrix3d::Zero();
        for (const Neighbor& neighbor : neighbors) {
          const Eigen::Vector3d offset = point(neighbor.index) - center;
          mean += offset;
          moment += offset * offset.transpose();
        }
        const double count = static_cast<double>(neighbors.size()) + 1;
        mean /= count;
        const SymmetricEigen3 spread =
            DecomposeSymmetric(moment / count - mean * mean.transpose());
        const Eigen::Vector3f normal = spread.vectors.col(0).cast<float>();
        std::copy_n(normal.data(), 3, normals.data() + row * size_t{3});
      });
  return normals;
}

}  // namespace freegs::semantics
