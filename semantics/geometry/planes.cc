// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/geometry/planes.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

#include "core/decompositions.h"
#include "core/quantile.h"
#include "core/random.h"

namespace freegs::semantics {
namespace {

constexpr double kMinNormalCosine = 0.9;
// At least this share of the points of a part must have the normal of the
// plane. Otherwise the part is a slice through other things.
constexpr double kMinAlongShare = 0.5;
// A plane holds at least this share of all points.
constexpr double kMinShare = 0.02;
// Candidate planes tried per plane found.
constexpr int kNumCandidates = 400;
// Cell of the connectivity test, in scene radii.
constexpr double kCellSize = 0.05;
// Sheets of one surface: their normals differ by at most 15 degrees.
constexpr double kSheetCosine = 0.966;
// Their points lie this near to each other, in scene radii.
constexpr double kSheetDistance = 0.05;

class PlaneFinder {
 public:
  PlaneFinder(std::span<const float> positions,
              std::span<const float> normals,
              double scene_radius,
              const PlaneOptions& options,
              uint64_t seed,
              ThreadPool& pool)
      : positions_(positions),
        normals_(normals),
        radius_(scene_radius),
        options_(options),
        seed_(seed),
        pool_(pool) {}

  PlaneSegmentation Run() {
    PlaneSegmentation result;
    const size_t count = positions_.size() / 3;
    result.plane_index.assign(count, -1);
    free_.resize(count);
    std::iota(free_.begin(), free_.end(), 0u);
    const double min_points = kMinShare * static_cast<double>(count);
    // The points of a plane that is too narrow are not tried again. A few such
    // failures in a row end the search.
    int failures = 0;
    for (uint64_t round = 0;
         static_cast<int>(result.planes.size()) < options_.max_planes &&
         failures < 4 && static_cast<double>(free_.size()) >= min_points &&
         free_.size() >= 3;
         ++round) {
      Plane plane = BestCandidate(round);
      std::vector<uint32_t> members = Refine(&plane);
      if (static_cast<double>(members.size()) < std::max(3.0, min_points)) {
        break;
      }
      std::vector<uint32_t> parts = LargeParts(plane, members);
      const bool accepted = static_cast<double>(parts.size()) >= min_points;
      if (accepted) {
        const auto index = static_cast<int32_t>(result.planes.size());
        for (const uint32_t row : parts) result.plane_index[row] = index;
        result.planes.push_back(plane);
        failures = 0;
      } else {
        ++failures;
      }
      Remove(accepted ? parts : members);
    }
    return result;
  }

 private:
  Eigen::Vector3d Position(uint32_t row) const {
    return {positions_[row * size_t{3}],
            positions_[row * size_t{3} + 1],
            positions_[row * size_t{3} + 2]};
  }
  Eigen::Vector3d Normal(uint32_t row) const {
    return {normals_[row * size_t{3}],
            normals_[row * size_t{3} + 1],
            normals_[row * size_t{3} + 2]};
  }

  bool Supports(const Plane& plane, uint32_t row, double distance) const {
    return std::abs(plane.SignedDistance(Position(row))) <= distance &&
           std::abs(plane.normal.dot(Normal(row))) >= kMinNormalCosine;
  }

  Plane BestCandidate(uint64_t round) const {
    std::vector<Plane> planes(kNumCandidates);
    std::vector<int64_t> scores(kNumCandidates, 0);
    pool_.ParallelFor(
        0, kNumCandidates, 1, [&](int64_t first, int64_t last, int) {
          for (int64_t c = first; c < last; ++c) {
            const uint32_t row =
                free_[RandomIndex(seed_, round, c, free_.size())];
            planes[c].normal = Normal(row);
            planes[c].offset = planes[c].normal.dot(Position(row));
            // Every fourth point is enough to rank candidates.
            for (size_t i = 0; i < free_.size(); i += 4) {
              scores[c] += Supports(
                  planes[c], free_[i], options_.max_distance * radius_);
            }
          }
        });
    return planes[std::max_element(scores.begin(), scores.end()) -
                  scores.begin()];
  }

  // Least squares on the supporting points, with a distance that shrinks to
  // their spread. Returns the points within that distance, whatever their
  // normals, because normals are mixed at the foot of an object.
  std::vector<uint32_t> Refine(Plane* plane) const {
    plane->distance = options_.max_distance * radius_;
    for (int iteration = 0; iteration < 6; ++iteration) {
      Eigen::Vector3d mean = Eigen::Vector3d::Zero();
      Eigen::Matrix3d moment = Eigen::Matrix3d::Zero();
      std::vector<uint32_t> support;
      for (const uint32_t row : free_) {
        if (Supports(*plane, row, plane->distance)) support.push_back(row);
      }
      if (support.size() < 3) return {};
      for (const uint32_t row : support) mean += Position(row);
      mean /= static_cast<double>(support.size());
      for (const uint32_t row : support) {
        const Eigen::Vector3d offset = Position(row) - mean;
        moment += offset * offset.transpose();
      }
      plane->normal = DecomposeSymmetric(moment).vectors.col(0);
      plane->offset = plane->normal.dot(mean);
      std::vector<double> residuals;
      for (const uint32_t row : support) {
        residuals.push_back(std::abs(plane->SignedDistance(Position(row))));
      }
      // Three standard deviations, by the median absolute residual.
      plane->distance =
          std::min(options_.max_distance * radius_,
                   std::max(3 * 1.4826 * UpperMedian(std::move(residuals)),
                            1e-3 * radius_));
    }
    std::vector<uint32_t> members;
    for (const uint32_t row : free_) {
      if (std::abs(plane->SignedDistance(Position(row))) <= plane->distance) {
        members.push_back(row);
      }
    }
    return members;
  }

  // The connected parts that are wide enough, and most of whose points have the
  // normal of the plane. Elsewhere other things cross the plane.
  std::vector<uint32_t> LargeParts(const Plane& plane,
                                   const std::vector<uint32_t>& members) const {
    const Eigen::Vector3d u = plane.normal.unitOrthogonal();
    const Eigen::Vector3d v = plane.normal.cross(u);
    using Cell = std::pair<int64_t, int64_t>;
    const auto cell_of = [&](uint32_t row) {
      const Eigen::Vector3d x = Position(row) / (kCellSize * radius_);
      return Cell(std::llround(u.dot(x)), std::llround(v.dot(x)));
    };
    std::map<Cell, std::vector<uint32_t>> cells;
    for (const uint32_t row : members) cells[cell_of(row)].push_back(row);
    std::vector<std::vector<uint32_t>> parts;
    std::map<Cell, bool> visited;
    for (const auto& [start, unused] : cells) {
      if (visited[start]) continue;
      visited[start] = true;
      std::vector<Cell> stack = {start};
      std::vector<uint32_t> part;
      while (!stack.empty()) {
        const Cell cell = stack.back();
        stack.pop_back();
        const std::vector<uint32_t>& rows = cells[cell];
        part.insert(part.end(), rows.begin(), rows.end());
        for (int64_t dy = -1; dy <= 1; ++dy) {
          for (int64_t dx = -1; dx <= 1; ++dx) {
            const Cell next(cell.first + dx, cell.second + dy);
            if (!cells.contains(next) || visited[next]) continue;
            visited[next] = true;
            stack.push_back(next);
          }
        }
      }
      parts.push_back(std::move(part));
    }
    std::vector<uint32_t> kept;
    for (const auto& part : parts) {
      size_t along = 0;
      for (const uint32_t row : part) {
        along += Supports(plane, row, plane.distance);
      }
      if (static_cast<double>(along) >=
              kMinAlongShare * static_cast<double>(part.size()) &&
          Width(part) >= options_.min_width * radius_) {
        kept.insert(kept.end(), part.begin(), part.end());
      }
    }
    std::sort(kept.begin(), kept.end());
    return kept;
  }

  // The shorter side of a part: the width of a uniform distribution whose
  // standard deviation is the smaller one of the part within the plane.
  double Width(const std::vector<uint32_t>& rows) const {
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const uint32_t row : rows) mean += Position(row);
    mean /= static_cast<double>(rows.size());
    Eigen::Matrix3d moment = Eigen::Matrix3d::Zero();
    for (const uint32_t row : rows) {
      const Eigen::Vector3d offset = Position(row) - mean;
      moment += offset * offset.transpose();
    }
    moment /= static_cast<double>(rows.size());
    const double variance = DecomposeSymmetric(moment).values[1];
    return std::sqrt(12 * std::max(0.0, variance));
  }

  void Remove(std::vector<uint32_t> rows) {
    std::sort(rows.begin(), rows.end());
    std::vector<uint32_t> rest;
    std::set_difference(free_.begin(),
                        free_.end(),
                        rows.begin(),
                        rows.end(),
                        std::back_inserter(rest));
    free_ = std::move(rest);
  }

  std::span<const float> positions_;
  std::span<const float> normals_;
  const double radius_;
  const PlaneOptions& options_;
  const uint64_t seed_;
  ThreadPool& pool_;
  std::vector<uint32_t> free_;  // Points of no plane yet, ascending.
};

// The distance from another plane within which half of the points lie.
double MedianDistance(std::span<const float> positions,
                      const std::vector<int32_t>& plane_index,
                      int32_t plane,
                      const Plane& other) {
  std::vector<double> distances;
  for (size_t i = 0; i < plane_index.size(); ++i) {
    if (plane_index[i] != plane) continue;
    distances.push_back(std::abs(other.SignedDistance(
        {positions[i * 3], positions[i * 3 + 1], positions[i * 3 + 2]})));
  }
  return UpperMedian(std::move(distances));
}

void JoinSheets(std::span<const float> positions,
                double distance,
                PlaneSegmentation* planes) {
  const auto count = static_cast<int32_t>(planes->planes.size());
  std::vector<int32_t> joined(count);  // New index of each plane.
  std::vector<Plane> kept;
  for (int32_t p = 0; p < count; ++p) {
    const Plane& plane = planes->planes[p];
    joined[p] = static_cast<int32_t>(kept.size());
    for (size_t k = 0; k < kept.size(); ++k) {
      if (std::abs(plane.normal.dot(kept[k].normal)) >= kSheetCosine &&
          MedianDistance(positions, planes->plane_index, p, kept[k]) <=
              distance) {
        joined[p] = static_cast<int32_t>(k);
        break;
      }
    }
    if (joined[p] == static_cast<int32_t>(kept.size())) kept.push_back(plane);
  }
  for (int32_t& index : planes->plane_index) {
    if (index >= 0) index = joined[index];
  }
  planes->planes = std::move(kept);
}

}  // namespace

Status PlaneOptions::Check() const {
  if (max_planes < 0 || max_planes > 1000) {
    return InvalidArgumentError("max_planes must lie in 0 .. 1000");
  }
  if (!(min_width >= 0) || !(max_distance > 0)) {
    return InvalidArgumentError(
        "min_width must not be negative and max_distance must be positive");
  }
  return {};
}

PlaneSegmentation FindPlanes(std::span<const float> positions,
                             std::span<const float> normals,
                             double scene_radius,
                             const PlaneOptions& options,
                             uint64_t seed,
                             ThreadPool& pool) {
  PlaneSegmentation planes =
      PlaneFinder(positions, normals, scene_radius, options, seed, pool).Run();
  JoinSheets(positions, kSheetDistance * scene_radius, &planes);
  return planes;
}

}  // namespace freegs::semantics
