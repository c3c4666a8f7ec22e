// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/patches/patch_graph.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <tuple>
#include <utility>

#include "core/pinhole.h"

namespace freegs::semantics {
namespace {

// A pixel shows the patch that is most of it, if all patches together have
// this much of its weight.
constexpr float kMinPixelWeight = 0.5f;
// Depths that differ by more than this many patch sizes are apart.
constexpr double kDepthJump = 1;
// The context of a patch reaches over so many neighbours.
constexpr int kContextSteps = 2;
// Normals and positions at creases are means over patches so many steps around,
// of colours that differ by less than about this (L*a*b* / 100).
constexpr int kCreaseSteps = 3;
constexpr double kAlikeColor = 0.06;
// Contacts of fewer pixels in all views together are chance.
constexpr double kMinCrossings = 2;

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

// Finds the patch that has most of a pixel's weight.
class PatchVote {
 public:
  explicit PatchVote(size_t num_patches) : share_(num_patches, 0.0f) {}

  // -1 if all patches together have too little. Of equals the front one.
  int32_t PatchShown(std::span<const uint32_t> gaussians,
                     std::span<const float> weights,
                     std::span<const int32_t> patch_of_gaussian) {
    float total = 0;
    int32_t shown = -1;
    for (size_t e = 0; e < gaussians.size(); ++e) {
      const int32_t patch = patch_of_gaussian[gaussians[e]];
      if (patch < 0) continue;
      total += weights[e];
      if (share_[patch] == 0) found_.push_back(patch);
      share_[patch] += weights[e];
      // The weights of a pixel sum to 1 at most: no other can have more.
      if (share_[patch] > 0.5f) {
        shown = patch;
        break;
      }
    }
    if (shown < 0 && total >= kMinPixelWeight) {
      shown = *std::max_element(
          found_.begin(), found_.end(), [this](int32_t a, int32_t b) {
            return share_[a] < share_[b];
          });
    }
    for (const int32_t patch : found_) share_[patch] = 0;
    found_.clear();
    return shown;
  }

 private:
  std::vector<float> share_;    // Share of each patch; 0 between pixels.
  std::vector<int32_t> found_;  // Patches with a share, front to back.
};

Eigen::Vector3d RowOf3(std::span<const float> rows, size_t i) {
  return {rows[i * 3], rows[i * 3 + 1], rows[i * 3 + 2]};
}

}  // namespace

Image<int32_t> PatchOfPixels(const splat::WeightMatrix& weights,
                             std::span<const int32_t> patch_of_gaussian) {
  Image<int32_t> patches(weights.width, weights.height, 1, -1);
  int32_t last_patch = -1;
  for (const int32_t patch : patch_of_gaussian) {
    last_patch = std::max(last_patch, patch);
  }
  PatchVote vote(static_cast<size_t>(last_patch + 1));
  for (size_t p = 0; p < patches.size(); ++p) {
    const uint32_t begin = weights.pixel_begin[p];
    const size_t count = weights.pixel_begin[p + 1] - begin;
    patches.data()[p] =
        vote.PatchShown(std::span(weights.gaussians).subspan(begin, count),
                        std::span(weights.weights).subspan(begin, count),
                        patch_of_gaussian);
  }
  return patches;
}

PatchGraphBuilder::PatchGraphBuilder(const splat::GaussianModel& model,
                                     std::vector<int32_t> patch_of_gaussian,
                                     std::span<const float> normals,
                                     std::vector<float> size_of_patch,
                                     std::vector<float> depth_scale)
    : model_(model),
      patch_of_gaussian_(std::move(patch_of_gaussian)),
      size_of_patch_(std::move(size_of_patch)),
      depth_scale_(std::move(depth_scale)),
      towards_camera_(size_of_patch_.size(), Eigen::Vector3d::Zero()),
      middle_(size_of_patch_.size(), Eigen::Vector3d::Zero()),
      normal_(size_of_patch_.size(), Eigen::Vector3d::Zero()) {
  graph_.regions.resize(size_of_patch_.size());
  std::vector<double> count(size_of_patch_.size(), 0.0);
  for (size_t g = 0; g < patch_of_gaussian_.size(); ++g) {
    const int32_t patch = patch_of_gaussian_[g];
    if (patch < 0) continue;
    middle_[patch] += RowOf3(model_.means, g);
    const Eigen::Vector3d normal = RowOf3(normals, g);
    normal_[patch] +=
        normal.dot(normal_[patch]) < 0 ? Eigen::Vector3d(-normal) : normal;
    count[patch] += 1;
  }
  for (size_t p = 0; p < middle_.size(); ++p) {
    middle_[p] /= std::max(1.0, count[p]);
    if (normal_[p].norm() > 0) normal_[p].normalize();
  }
}

class PatchGraphBuilder::PatchDepths {
 public:
  PatchDepths(const PatchGraphBuilder& builder, const View& view)
      : builder_(builder), camera_(view.camera) {
    for (size_t p = 0; p < builder.middle_.size(); ++p) {
      middle_.emplace_back(view.cam_from_world * builder.middle_[p]);
      normal_.emplace_back(view.cam_from_world.rotation * builder.normal_[p]);
    }
  }

  // Where the ray through a point of the image meets the plane of a patch, but
  // not farther from its middle than the patch is large.
  double At(int32_t patch, double u, double v) const {
    const Eigen::Vector3d ray(
        (u - camera_.cx) / camera_.fx, (v - camera_.cy) / camera_.fy, 1);
    const Eigen::Vector3d& normal = normal_[patch];
    const double middle = middle_[patch].z();
    const double size = builder_.size_of_patch_[patch];
    const double slope = normal.dot(ray);
    if (std::abs(slope) < 1e-6) return middle;
    return std::clamp(
        normal.dot(middle_[patch]) / slope, middle - size, middle + size);
  }

  // The step in depth between two patches, in sizes of patches.
  double Step(int32_t a, int32_t b, double u, double v) const {
    return std::abs(At(a, u, v) - At(b, u, v)) /
           (0.5 * (builder_.depth_scale_[a] + builder_.depth_scale_[b]));
  }

 private:
  const PatchGraphBuilder& builder_;
  const Pinhole camera_;
  std::vector<Eigen::Vector3d> middle_;
  std::vector<Eigen::Vector3d> normal_;
};

// What tells of the boundaries between patches in a view.
struct PatchGraphBuilder::Boundaries {
  const Image<int32_t>& labels;  // The patch that each pixel shows.
  const PatchDepths& depths;
  const ViewCues& cues;

  // Appends those from the pixels of row y to the pixels on the right and
  // below.
  void OfRow(int y, std::vector<Crossing>* crossings) const {
    for (int x = 0; x < labels.width(); ++x) {
      // Every second pixel, as on a chessboard, tells enough.
      if ((x + y) % 2 != 0) continue;
      const int32_t here = labels(x, y);
      if (here < 0) continue;
      for (const bool horizontal : {true, false}) {
        const int nx = horizontal ? x + 1 : x;
        const int ny = horizontal ? y : y + 1;
        if (nx >= labels.width() || ny >= labels.height()) continue;
        const int32_t next = labels(nx, ny);
        if (next < 0 || next == here) continue;
        Crossing crossing;
        std::tie(crossing.a, crossing.b) = std::minmax(here, next);
        const double step =
            depths.Step(here, next, 0.5 * (x + nx) + 0.5, 0.5 * (y + ny) + 0.5);
        crossing.stats.relief =
            cues.relief.Step(x, y, horizontal, cues.relief_reach);
        if (step > kDepthJump) {
          crossing.stats.hidden = 1;
        } else {
          const auto fine =
              cues.contrast.Across(x, y, horizontal, cues.near_reach);
          const auto coarse =
              cues.contrast.Across(x, y, horizontal, cues.far_reach);
          crossing.stats.pixels = 1;
          crossing.stats.contrast_near = fine.contrast;
          crossing.stats.contrast_far = coarse.contrast;
          crossing.stats.difference = fine.difference;
          crossing.stats.depth_step = step;
        }
        crossings->push_back(crossing);
      }
    }
  }
};

void PatchGraphBuilder::AddView(const ViewCues& cues) {
  const Image<int32_t> labels = PatchOfPixels(cues.weights, patch_of_gaussian_);
  AddPixels(labels, cues.lab);
  const PatchDepths depths(*this, cues.view);
  const Boundaries boundaries{.labels = labels, .depths = depths, .cues = cues};
  std::vector<Crossing> crossings;
  for (int y = 0; y < labels.height(); ++y) {
    crossings.clear();
    boundaries.OfRow(y, &crossings);
    AddCrossings(crossings);
  }

  const Eigen::Vector3d camera = CameraCentre(cues.view.cam_from_world);
  for (size_t p = 0; p < labels.size(); ++p) {
    const int32_t patch = labels.data()[p];
    if (patch < 0) continue;
    towards_camera_[patch] += (camera - middle_[patch]).normalized();
  }
  graph_.total_pixels += static_cast<double>(labels.size());
}

void PatchGraphBuilder::AddPixels(const Image<int32_t>& labels,
                                  const ImageF& lab) {
  for (size_t p = 0; p < labels.size(); ++p) {
    const int32_t patch = labels.data()[p];
    if (patch < 0) continue;
    RegionStats& region = graph_.regions[patch];
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

void PatchGraphBuilder::AddGaussians(std::span<const double> seen) {
  for (uint32_t g = 0; g < patch_of_gaussian_.size(); ++g) {
    const int32_t patch = patch_of_gaussian_[g];
    if (patch < 0) continue;
    RegionStats& region = graph_.regions[patch];
    const Eigen::Vector3d x = RowOf3(model_.means, g);
    region.weight += seen[g];
    region.position += seen[g] * x;
    region.position2 += seen[g] * x * x.transpose();
  }
  for (size_t p = 0; p < normal_.size(); ++p) {
    if (normal_[p].dot(towards_camera_[p]) < 0) normal_[p] = -normal_[p];
  }
}

void PatchGraphBuilder::AddCreases() {
  // Means over neighbours of similar colour, which lie on the same side.
  std::vector<Eigen::Vector3d> position = middle_;
  std::vector<Eigen::Vector3d> normal = normal_;
  for (int step = 0; step < kCreaseSteps; ++step) {
    std::vector<Eigen::Vector3d> position_sum;
    std::vector<Eigen::Vector3d> normal_sum;
    std::vector<double> weight(position.size());
    for (size_t p = 0; p < position.size(); ++p) {
      weight[p] = graph_.regions[p].pixels;
      position_sum.push_back(weight[p] * position[p]);
      normal_sum.push_back(weight[p] * normal[p]);
    }
    for (const Contact& contact : graph_.contacts) {
      const RegionStats& a = graph_.regions[contact.a];
      const RegionStats& b = graph_.regions[contact.b];
      if (!(a.pixels > 0) || !(b.pixels > 0)) continue;
      const double difference =
          (a.color / a.pixels - b.color / b.pixels).norm();
      const double alike = std::exp(-difference / kAlikeColor);
      position_sum[contact.a] += alike * b.pixels * position[contact.b];
      position_sum[contact.b] += alike * a.pixels * position[contact.a];
      normal_sum[contact.a] += alike * b.pixels * normal[contact.b];
      normal_sum[contact.b] += alike * a.pixels * normal[contact.a];
      weight[contact.a] += alike * b.pixels;
      weight[contact.b] += alike * a.pixels;
    }
    for (size_t p = 0; p < position.size(); ++p) {
      if (!(weight[p] > 0)) continue;
      position[p] = position_sum[p] / weight[p];
      if (normal_sum[p].norm() > 0) normal[p] = normal_sum[p].normalized();
    }
  }
  for (Contact& contact : graph_.contacts) {
    const Eigen::Vector3d between = position[contact.a] - position[contact.b];
    const double distance = between.norm();
    const double pixels = contact.stats.pixels;
    if (distance > 0) {
      contact.stats.concavity =
          pixels * (normal[contact.b] - normal[contact.a]).dot(between) /
          distance;
    }
    contact.stats.bend =
        pixels * (1 - normal[contact.a].dot(normal[contact.b]));
  }
}

void PatchGraphBuilder::AddContext() {
  for (RegionStats& region : graph_.regions) {
    region.context = region.histogram;
    region.context_pixels = region.pixels;
  }
  for (int step = 0; step < kContextSteps; ++step) {
    std::vector<ColorHistogram> around;
    std::vector<double> pixels;
    for (const RegionStats& region : graph_.regions) {
      around.push_back(region.context);
      pixels.push_back(region.context_pixels);
    }
    for (const Contact& contact : graph_.contacts) {
      RegionStats& a = graph_.regions[contact.a];
      RegionStats& b = graph_.regions[contact.b];
      AddHistogram(around[contact.b], &a.context);
      AddHistogram(around[contact.a], &b.context);
      a.context_pixels += pixels[contact.b];
      b.context_pixels += pixels[contact.a];
    }
  }
}

RegionGraph PatchGraphBuilder::Finish(std::span<const double> seen) {
  AddGaussians(seen);
  std::erase_if(graph_.contacts, [](const Contact& contact) {
    return contact.stats.pixels < kMinCrossings;
  });
  std::sort(graph_.contacts.begin(),
            graph_.contacts.end(),
            [](const Contact& x, const Contact& y) {
              return std::pair(x.a, x.b) < std::pair(y.a, y.b);
            });
  AddContext();
  AddCreases();
  return std::move(graph_);
}

}  // namespace freegs::semantics
