// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/instances/crease_split.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>
#include <utility>

#include <Eigen/Core>

#include "core/kd_tree.h"

namespace freegs::semantics {
namespace {

constexpr int kNumContactNeighbors = 10;
constexpr int kPatchIterations = 5;
// About the largest number of patches of a cluster. Larger clusters get larger
// patches.
constexpr double kMaxPatchesPerSide = 24;
// Weight of a difference of one in colour or normal, where a distance of one
// patch size in position has weight one.
constexpr double kColorWeight = 1.5;
constexpr double kNormalWeight = 1.0;

struct Patch {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Vector3d color = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  double count = 0;
};

// The contact of two patches or parts.
struct PartContact {
  double length = 0;     // Pairs of neighbouring points.
  double concavity = 0;  // Sum over these pairs.
};

// One cluster: its points, cut into parts.
class ClusterCutter {
 public:
  ClusterCutter(std::span<const float> positions,
                std::span<const float> colors,
                std::span<const float> normals,
                const std::vector<uint32_t>& rows,
                const CreaseSplitOptions& options)
      : options_(options) {
    points_.reserve(rows.size());
    for (const uint32_t row : rows) {
      Patch point;
      for (int k = 0; k < 3; ++k) {
        point.position[k] = positions[row * size_t{3} + k];
        point.color[k] = colors[row * size_t{3} + k];
        point.normal[k] = normals[row * size_t{3} + k];
        flat_positions_.push_back(positions[row * size_t{3} + k]);
      }
      points_.push_back(point);
    }
  }

  // The part of each point, 0 .. n - 1, largest first.
  std::vector<int32_t> Run() {
    const auto tree = KdTree::Build(flat_positions_, 3);
    if (!tree.ok()) return std::vector<int32_t>(points_.size(), 0);
    MakePatches();
    FindContacts(*tree);
    JoinPatches();
    return Parts();
  }

 private:
  double FeatureDistance2(const Patch& a, const Patch& b, double size) const {
    return ((a.position - b.position) / size).squaredNorm() +
           (kColorWeight * (a.color - b.color)).squaredNorm() +
           (kNormalWeight * (a.normal - b.normal)).squaredNorm();
  }

  // Patches begin as the cells of a grid. Then points move to the nearest of
  // the patches around them, as in k-means.
  void MakePatches() {
    Eigen::Vector3d low = points_[0].position;
    Eigen::Vector3d high = low;
    for (const Patch& point : points_) {
      low = low.cwiseMin(point.position);
      high = high.cwiseMax(point.position);
    }
    const double size = std::max(options_.patch_size,
                                 (high - low).maxCoeff() / kMaxPatchesPerSide);
    using Cell = std::array<int64_t, 3>;
    const auto cell_of = [&](const Patch& point) {
      Cell cell;
      for (int k = 0; k < 3; ++k) {
        cell[k] = static_cast<int64_t>(
            std::floor((point.position[k] - low[k]) / size));
      }
      return cell;
    };
    patch_of_point_.resize(points_.size());
    std::map<Cell, int32_t> patch_of_cell;
    for (size_t i = 0; i < points_.size(); ++i) {
      const auto [it, added] = patch_of_cell.try_emplace(
          cell_of(points_[i]), static_cast<int32_t>(patch_of_cell.size()));
      patch_of_point_[i] = it->second;
    }
    const size_t num_patches = patch_of_cell.size();
    for (int iteration = 0;; ++iteration) {
      patches_.assign(num_patches, Patch());
      for (size_t i = 0; i < points_.size(); ++i) {
        Patch& patch = patches_[patch_of_point_[i]];
        patch.position += points_[i].position;
        patch.color += points_[i].color;
        patch.normal += points_[i].normal;
        patch.count += 1;
      }
      for (Patch& patch : patches_) {
        if (patch.count == 0) continue;
        patch.position /= patch.count;
        patch.color /= patch.count;
        const double norm = patch.normal.norm();
        if (norm > 0) patch.normal /= norm;
      }
      if (iteration == kPatchIterations) break;
      std::map<Cell, std::vector<int32_t>> patches_in_cell;
      for (size_t p = 0; p < num_patches; ++p) {
        if (patches_[p].count > 0) {
          patches_in_cell[cell_of(patches_[p])].push_back(
              static_cast<int32_t>(p));
        }
      }
      for (size_t i = 0; i < points_.size(); ++i) {
        const Cell cell = cell_of(points_[i]);
        double least =
            FeatureDistance2(points_[i], patches_[patch_of_point_[i]], size);
        for (int64_t neighbor = 0; neighbor < 27; ++neighbor) {
          const auto found =
              patches_in_cell.find({cell[0] + neighbor % 3 - 1,
                                    cell[1] + neighbor / 3 % 3 - 1,
                                    cell[2] + neighbor / 9 - 1});
          if (found == patches_in_cell.end()) continue;
          for (const int32_t p : found->second) {
            const double distance =
                FeatureDistance2(points_[i], patches_[p], size);
            if (distance < least) {
              least = distance;
              patch_of_point_[i] = p;
            }
          }
        }
      }
    }
  }

  void FindContacts(const KdTree& tree) {
    contacts_.resize(patches_.size());
    std::vector<Neighbor> neighbors;
    for (uint32_t i = 0; i < points_.size(); ++i) {
      tree.Nearest(flat_positions_.data() + i * size_t{3},
                   kNumContactNeighbors,
                   i,
                   &neighbors);
      for (const Neighbor& neighbor : neighbors) {
        const int32_t a = patch_of_point_[i];
        const int32_t b = patch_of_point_[neighbor.index];
        if (a == b) continue;
        const Eigen::Vector3d between =
            patches_[a].position - patches_[b].position;
        const double distance = between.norm();
        const double concavity =
            distance > 0
                ? (patches_[b].normal - patches_[a].normal).dot(between) /
                      distance
                : 0;
        for (const auto& [from, to] : {std::pair(a, b), std::pair(b, a)}) {
          PartContact& contact = contacts_[from][to];
          contact.length += 1;
          contact.concavity += concavity;
        }
      }
    }
  }

  double Contrast(int32_t a, int32_t b, const PartContact& contact) const {
    // Never quite 0, so that among pairs that are not concave those of similar
    // colour are joined first.
    const double concavity = std::max(contact.concavity / contact.length, 0.01);
    return concavity * (patches_[a].color - patches_[b].color).norm();
  }

  // Joins b to a.
  void Join(int32_t a, int32_t b) {
    Patch& to = patches_[a];
    const Patch& from = patches_[b];
    const double count = to.count + from.count;
    to.color = (to.count * to.color + from.count * from.color) / count;
    to.count = count;
    patches_[b].count = 0;
    for (const auto& [other, contact] : contacts_[b]) {
      contacts_[other].erase(b);
      if (other == a) continue;
      for (const auto& [x, y] : {std::pair(a, other), std::pair(other, a)}) {
        contacts_[x][y].length += contact.length;
        contacts_[x][y].concavity += contact.concavity;
      }
    }
    contacts_[b].clear();
    for (int32_t& p : patch_of_point_) {
      if (p == b) p = a;
    }
  }

  // The pair of touching parts with the least contrast. The contrast is below
  // the limit or, with only_small, part `a` is too small. (-1, -1) if there is
  // no such pair.
  std::pair<int32_t, int32_t> LeastContrast(bool only_small) const {
    double least = only_small ? std::numeric_limits<double>::infinity()
                              : options_.min_contrast;
    std::pair<int32_t, int32_t> pair(-1, -1);
    for (int32_t a = 0; a < static_cast<int32_t>(contacts_.size()); ++a) {
      if (only_small && patches_[a].count >= options_.min_part_size) continue;
      for (const auto& [b, contact] : contacts_[a]) {
        const double contrast = Contrast(a, b, contact);
        if (contrast < least) {
          least = contrast;
          pair = {a, b};
        }
      }
    }
    return pair;
  }

  void JoinPatches() {
    for (;;) {
      auto [a, b] = LeastContrast(/*only_small=*/false);
      if (a < 0) std::tie(a, b) = LeastContrast(/*only_small=*/true);
      if (a < 0) return;
      if (patches_[a].count < patches_[b].count) std::swap(a, b);
      Join(a, b);
    }
  }

  std::vector<int32_t> Parts() const {
    std::vector<int32_t> order;
    for (int32_t p = 0; p < static_cast<int32_t>(patches_.size()); ++p) {
      if (patches_[p].count > 0) order.push_back(p);
    }
    std::stable_sort(order.begin(), order.end(), [&](int32_t a, int32_t b) {
      return patches_[a].count > patches_[b].count;
    });
    // A part that is too small and touches no other joins the largest part.
    std::vector<int32_t> part(patches_.size(), 0);
    int32_t next = 0;
    for (const int32_t p : order) {
      part[p] =
          patches_[p].count >= options_.min_part_size || next == 0 ? next++ : 0;
    }
    std::vector<int32_t> result;
    result.reserve(points_.size());
    for (const int32_t p : patch_of_point_) result.push_back(part[p]);
    return result;
  }

  const CreaseSplitOptions& options_;
  std::vector<Patch> points_;  // Patches of one point; count unused.
  std::vector<float> flat_positions_;
  std::vector<Patch> patches_;
  std::vector<int32_t> patch_of_point_;
  std::vector<std::map<int32_t, PartContact>>
      contacts_;  // By patch, symmetric.
};

}  // namespace

Status CreaseSplitOptions::Check() const {
  if (!(min_contrast >= 0) || !(patch_size > 0) || min_part_size < 1) {
    return InvalidArgumentError(
        "min_contrast must not be negative, patch_size and min_part_size must "
        "be positive");
  }
  return {};
}

void SplitAtCreases(std::span<const float> positions,
                    std::span<const float> colors,
                    std::span<const float> normals,
                    const CreaseSplitOptions& options,
                    ThreadPool& pool,
                    std::vector<int32_t>* labels) {
  if (options.min_contrast <= 0) return;
  int32_t num_labels = 0;
  for (const int32_t label : *labels) {
    num_labels = std::max(num_labels, label + 1);
  }
  std::vector<std::vector<uint32_t>> rows(num_labels);
  for (uint32_t i = 0; i < labels->size(); ++i) {
    if ((*labels)[i] >= 0) rows[(*labels)[i]].push_back(i);
  }
  std::vector<std::vector<int32_t>> parts(num_labels);
  pool.ParallelFor(0, num_labels, 1, [&](int64_t first, int64_t last, int) {
    for (int64_t label = first; label < last; ++label) {
      if (rows[label].size() >=
          2 * static_cast<size_t>(options.min_part_size)) {
        parts[label] =
            ClusterCutter(positions, colors, normals, rows[label], options)
                .Run();
      }
    }
  });
  for (int32_t label = 0, end = num_labels; label < end; ++label) {
    int32_t last_part = 0;
    for (size_t i = 0; i < parts[label].size(); ++i) {
      const int32_t part = parts[label][i];
      last_part = std::max(last_part, part);
      if (part > 0) (*labels)[rows[label][i]] = num_labels + part - 1;
    }
    num_labels += last_part;
  }
}

}  // namespace freegs::semantics
