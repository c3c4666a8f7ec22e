// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/patches/patch_graph.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/kd_tree.h"
#include "semantics/patches/local_contrast.h"

namespace freegs::semantics {
namespace {

// A pixel shows the patch that is most of it, if all patches together have
// this much of its weight.
constexpr float kMinPixelWeight = 0.5f;
// Depths that differ by more than this many patch sizes are apart.
constexpr double kDepthJump = 2.5;
// Depth of the windows on both sides of a boundary, in pixels of images of
// which the longer side has kReferenceSide.
constexpr int kReferenceSide = 400;
constexpr double kNearReach = 3;
constexpr double kFarReach = 8;
// Gaussians touch if they are among the nearest and not farther apart than so
// many patch sizes.
constexpr int kNeighbors = 8;
constexpr double kMaxDistance = 1.5;
// Contacts of fewer pixels in all views together are chance.
constexpr double kMinCrossings = 3;
constexpr int64_t kPixelRowGrain = 4;
constexpr int64_t kGaussianGrain = 1024;

// Ranges of L*a*b* / 100 that the histograms cover.
constexpr double kLowest[3] = {0, -0.6, -0.6};
constexpr double kRange[3] = {1, 1.2, 1.2};

// Shares a count between the two nearest bins.
void AddToHistogram(double value,
                    int channel,
                    std::array<float, kColorBins>* bins) {
  const double at = std::clamp(
      (value - kLowest[channel]) / kRange[channel] * (kColorBins - 1),
      0.0,
      kColorBins - 1.0001);
  const auto bin = static_cast<size_t>(at);
  const auto share = static_cast<float>(at - static_cast<double>(bin));
  (*bins)[bin] += 1 - share;
  (*bins)[bin + 1] += share;
}

int Reach(double at_reference, const ImageF& image) {
  const int side = std::max(image.width(), image.height());
  return std::max(
      2, static_cast<int>(std::lround(at_reference * side / kReferenceSide)));
}

Eigen::Vector3d RowOf3(std::span<const float> rows, size_t i) {
  return {rows[i * 3], rows[i * 3 + 1], rows[i * 3 + 2]};
}

}  // namespace

PatchGraphBuilder::PatchGraphBuilder(const splat::GaussianModel& model,
                                     std::vector<int32_t> patch_of_gaussian,
                                     std::vector<float> normals,
                                     std::vector<float> size_of_patch)
    : model_(model),
      patch_of_gaussian_(std::move(patch_of_gaussian)),
      normals_(std::move(normals)),
      size_of_patch_(std::move(size_of_patch)),
      seen_(model.size(), 0.0),
      towards_camera_(size_of_patch_.size(), Eigen::Vector3d::Zero()),
      middle_(size_of_patch_.size(), Eigen::Vector3d::Zero()) {
  graph_.regions.resize(size_of_patch_.size());
  std::vector<double> count(size_of_patch_.size(), 0.0);
  for (size_t g = 0; g < patch_of_gaussian_.size(); ++g) {
    const int32_t patch = patch_of_gaussian_[g];
    if (patch < 0) continue;
    middle_[patch] += RowOf3(model_.means, g);
    count[patch] += 1;
  }
  for (size_t p = 0; p < middle_.size(); ++p) {
    middle_[p] /= std::max(1.0, count[p]);
  }
}

Status PatchGraphBuilder::AddView(const splat::WeightMatrix& weights,
                                  const Rigid3d& cam_from_world,
                                  const ImageF& photo,
                                  ThreadPool& pool) {
  const int width = weights.width;
  const int height = weights.height;
  if (photo.width() != width || photo.height() != height ||
      weights.num_gaussians != model_.size()) {
    return InvalidArgumentError(
        "weights and photograph of a view differ in size");
  }
  const Eigen::Matrix<double, 3, 4> pose = cam_from_world.Matrix3x4();
  std::vector<float> depth(model_.size());
  pool.ParallelFor(
      0,
      static_cast<int64_t>(depth.size()),
      kGaussianGrain,
      [&](int64_t first, int64_t last, int) {
        for (int64_t g = first; g < last; ++g) {
          depth[g] = static_cast<float>(
              pose.row(2).head<3>().dot(RowOf3(model_.means, g)) + pose(2, 3));
        }
      });
  std::vector<PixelLabel> labels(weights.num_pixels());
  pool.ParallelFor(
      0, height, kPixelRowGrain, [&](int64_t first, int64_t last, int) {
        struct Share {
          int32_t patch;
          float weight;
          float depth;
        };
        std::vector<Share> shares;
        for (int64_t p = first * width; p < last * width; ++p) {
          shares.clear();
          for (uint32_t e = weights.pixel_begin[p];
               e < weights.pixel_begin[p + 1];
               ++e) {
            const uint32_t g = weights.gaussians[e];
            const int32_t patch = patch_of_gaussian_[g];
            if (patch < 0) continue;
            const float weight = weights.weights[e];
            const auto same =
                std::find_if(shares.begin(), shares.end(), [&](const Share& s) {
                  return s.patch == patch;
                });
            if (same != shares.end()) {
              same->weight += weight;
              same->depth += weight * depth[g];
            } else {
              shares.push_back({patch, weight, weight * depth[g]});
            }
          }
          const auto most = std::max_element(
              shares.begin(), shares.end(), [](const Share& a, const Share& b) {
                return a.weight < b.weight;
              });
          float total = 0;
          for (const Share& share : shares) total += share.weight;
          if (total >= kMinPixelWeight) {
            labels[p] = {most->patch, most->depth / most->weight};
          }
        }
      });
  for (size_t e = 0; e < weights.gaussians.size(); ++e) {
    seen_[weights.gaussians[e]] += weights.weights[e];
  }

  const ImageF lab = ToLab(photo);
  AddPixels(labels, lab);
  const LocalContrast contrast(lab);
  const int near = Reach(kNearReach, photo);
  const int far = Reach(kFarReach, photo);
  std::vector<std::vector<Crossing>> crossings(height);
  pool.ParallelFor(
      0, height, kPixelRowGrain, [&](int64_t first, int64_t last, int) {
        for (int y = static_cast<int>(first); y < last; ++y) {
          for (int x = 0; x < width; ++x) {
            const PixelLabel& here = labels[static_cast<size_t>(y) * width + x];
            if (here.patch < 0) continue;
            for (const bool horizontal : {true, false}) {
              const int nx = horizontal ? x + 1 : x;
              const int ny = horizontal ? y : y + 1;
              if (nx >= width || ny >= height) continue;
              const PixelLabel& next =
                  labels[static_cast<size_t>(ny) * width + nx];
              if (next.patch < 0 || next.patch == here.patch) continue;
              Crossing crossing;
              std::tie(crossing.a, crossing.b) =
                  std::minmax(here.patch, next.patch);
              const double step = std::abs(double{here.depth} - next.depth) /
                                  (0.5 * (size_of_patch_[here.patch] +
                                          size_of_patch_[next.patch]));
              if (step > kDepthJump) {
                crossing.stats.hidden = 1;
              } else {
                const auto fine = contrast.Across(x, y, horizontal, near);
                const auto coarse = contrast.Across(x, y, horizontal, far);
                crossing.stats.pixels = 1;
                crossing.stats.contrast_near = fine.contrast;
                crossing.stats.contrast_far = coarse.contrast;
                crossing.stats.difference = fine.difference;
                crossing.stats.depth_step = step;
              }
              crossings[y].push_back(crossing);
            }
          }
        }
      });
  for (const std::vector<Crossing>& row : crossings) AddCrossings(row);

  const Eigen::Vector3d camera =
      -(cam_from_world.rotation.conjugate() * cam_from_world.translation);
  for (const PixelLabel& label : labels) {
    if (label.patch < 0) continue;
    towards_camera_[label.patch] +=
        (camera - middle_[label.patch]).normalized();
  }
  graph_.total_pixels += static_cast<double>(labels.size());
  return Status();
}

void PatchGraphBuilder::AddPixels(const std::vector<PixelLabel>& labels,
                                  const ImageF& lab) {
  for (size_t p = 0; p < labels.size(); ++p) {
    if (labels[p].patch < 0) continue;
    RegionStats& region = graph_.regions[labels[p].patch];
    region.pixels += 1;
    for (int c = 0; c < 3; ++c) {
      const double value = lab.data()[p * 3 + c];
      region.color[c] += value;
      region.color2[c] += value * value;
      AddToHistogram(value, c, &region.histogram[c]);
    }
  }
}

ContactStats& PatchGraphBuilder::ContactOf(int32_t a, int32_t b) {
  const uint64_t key =
      static_cast<uint64_t>(a) << 32 | static_cast<uint32_t>(b);
  const auto [it, added] =
      contact_index_.try_emplace(key, graph_.contacts.size());
  if (added) graph_.contacts.push_back({a, b, {}});
  return graph_.contacts[it->second].stats;
}

void PatchGraphBuilder::AddCrossings(const std::vector<Crossing>& crossings) {
  for (const Crossing& crossing : crossings) {
    ContactOf(crossing.a, crossing.b).Add(crossing.stats);
    graph_.regions[crossing.a].perimeter += 1;
    graph_.regions[crossing.b].perimeter += 1;
  }
}

Status PatchGraphBuilder::AddGaussians(std::span<const float> semantics,
                                       int dim,
                                       ThreadPool& pool) {
  std::vector<uint32_t> rows;
  std::vector<float> positions;
  std::vector<Eigen::Vector3d> normal(size_of_patch_.size(),
                                      Eigen::Vector3d::Zero());
  for (uint32_t g = 0; g < patch_of_gaussian_.size(); ++g) {
    const int32_t patch = patch_of_gaussian_[g];
    if (patch < 0) continue;
    rows.push_back(g);
    for (size_t k = 0; k < 3; ++k) {
      positions.push_back(model_.means[g * size_t{3} + k]);
    }
    const Eigen::Vector3d n = RowOf3(normals_, g);
    normal[patch] += n.dot(normal[patch]) < 0 ? Eigen::Vector3d(-n) : n;
    RegionStats& region = graph_.regions[patch];
    const Eigen::Vector3d x = RowOf3(model_.means, g);
    region.weight += seen_[g];
    region.position += seen_[g] * x;
    region.position2 += seen_[g] * x * x.transpose();
    if (dim == 0) continue;
    region.semantics.resize(dim, 0.0f);
    const float* vector = semantics.data() + static_cast<size_t>(g) * dim;
    double norm2 = 0;
    for (int k = 0; k < dim; ++k) norm2 += double{vector[k]} * vector[k];
    if (!(norm2 > 0)) continue;
    const double scale = seen_[g] / std::sqrt(norm2);
    for (int k = 0; k < dim; ++k) {
      region.semantics[k] += static_cast<float>(scale * vector[k]);
    }
  }
  for (size_t p = 0; p < normal.size(); ++p) {
    if (normal[p].norm() > 0) normal[p].normalize();
    if (normal[p].dot(towards_camera_[p]) < 0) normal[p] = -normal[p];
  }
  FREEGS_ASSIGN_OR_RETURN(const KdTree tree, KdTree::Build(positions, 3));
  std::vector<std::array<int32_t, kNeighbors>> touching(rows.size());
  pool.ParallelFor(
      0,
      static_cast<int64_t>(rows.size()),
      kGaussianGrain,
      [&](int64_t first, int64_t last, int) {
        std::vector<Neighbor> nearest;
        for (int64_t i = first; i < last; ++i) {
          touching[i].fill(-1);
          const int32_t patch = patch_of_gaussian_[rows[i]];
          tree.Nearest(positions.data() + i * 3,
                       kNeighbors,
                       static_cast<uint32_t>(i),
                       &nearest);
          for (size_t k = 0; k < nearest.size(); ++k) {
            const int32_t other = patch_of_gaussian_[rows[nearest[k].index]];
            const double reach =
                kMaxDistance * 0.5 *
                (size_of_patch_[patch] + size_of_patch_[other]);
            if (other != patch && nearest[k].distance2 <= reach * reach) {
              touching[i][k] = other;
            }
          }
        }
      });
  for (size_t i = 0; i < rows.size(); ++i) {
    const int32_t patch = patch_of_gaussian_[rows[i]];
    for (const int32_t other : touching[i]) {
      if (other < 0) continue;
      const Eigen::Vector3d between = middle_[patch] - middle_[other];
      const double distance = between.norm();
      ContactStats& contact =
          ContactOf(std::min(patch, other), std::max(patch, other));
      contact.points += 1;
      if (distance > 0) {
        contact.concavity +=
            (normal[other] - normal[patch]).dot(between) / distance;
      }
      contact.bend += 1 - normal[patch].dot(normal[other]);
    }
  }
  return Status();
}

StatusOr<RegionGraph> PatchGraphBuilder::Finish(
    std::span<const float> semantics, int dim, ThreadPool& pool) {
  FREEGS_RETURN_IF_ERROR(AddGaussians(semantics, dim, pool));
  // What no photograph shows is not compared.
  std::erase_if(graph_.contacts, [](const Contact& contact) {
    return contact.stats.pixels < kMinCrossings;
  });
  std::sort(graph_.contacts.begin(),
            graph_.contacts.end(),
            [](const Contact& x, const Contact& y) {
              return std::pair(x.a, x.b) < std::pair(y.a, y.b);
            });
  return std::move(graph_);
}

}  // namespace freegs::semantics
