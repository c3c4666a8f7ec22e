// SPDX-License-Identifier: BSD-3-Clause
// The adaptive density control of 3D Gaussian Splatting (Kerbl et al. 2023,
// section 5), which clones, splits and prunes Gaussians, and the blur split of
// Mini-Splatting (Fang and Wang 2024, section 4.1). Opacities are not reset as
// they are there; what stands in front of cameras is removed
// (splat/density/camera_clearance.h).

#ifndef FREEGS_SPLAT_DENSITY_DENSIFICATION_H_
#define FREEGS_SPLAT_DENSITY_DENSIFICATION_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/image.h"
#include "core/parallel.h"
#include "core/status.h"
#include "splat/optim/adam.h"
#include "splat/scene/gaussian_model.h"

namespace freegs::splat {

// What is known of each Gaussian from the steps since the last densification.
struct DensificationStatistics {
  // The sum of |d loss / d projected mean| over the steps whose view showed the
  // Gaussian. As in 3DGS image coordinates are in [-1, 1] here.
  std::vector<float> gradient_sum;

  // Number of those steps.
  std::vector<uint32_t> visible_steps;

  // The largest share of the pixels of one picture at which the Gaussian had
  // the largest blending weight of all.
  std::vector<float> max_dominant_share;

  size_t size() const { return gradient_sum.size(); }

  // Makes all arrays hold zeros for `count` Gaussians.
  void Reset(size_t count);

  // Adds one step with a picture of width x height. `visible` lists the
  // Gaussians seen (no repeats); entry k of the other arrays belongs to
  // visible[k]. pixel_gradients is d loss / d(projected mean in pixels), x and
  // y interleaved.
  void AddView(std::span<const uint32_t> visible,
               std::span<const float> pixel_gradients,
               int width,
               int height,
               ThreadPool& pool);

  // Adds one picture. `dominant` is H x W: the Gaussian with the largest weight
  // at each pixel or -1, see ViewContributions.
  void AddDominant(const Image<int32_t>& dominant, ThreadPool& pool);

  // gradient_sum / visible_steps, or 0 for a Gaussian never seen.
  float MeanGradient(size_t index) const {
    return visible_steps[index] == 0
               ? 0.0f
               : gradient_sum[index] / static_cast<float>(visible_steps[index]);
  }

  // Keeps only the Gaussians listed; see GaussianModel::Select.
  void Select(std::span<const uint32_t> indices);

 private:
  // By thread and Gaussian. Scratch; all zeros between calls.
  std::vector<uint32_t> pixel_counts_;
};

struct DensificationOptions {
  // Gaussians whose mean gradient is at least this are cloned or split, in the
  // units of DensificationStatistics::gradient_sum.
  double gradient_threshold = 2e-4;

  // A Gaussian whose largest standard deviation is at most this is cloned, a
  // larger one is split. A share of the scene extent.
  double clone_max_scale = 0.01;

  // A split replaces a Gaussian by two at positions drawn from it, with
  // standard deviations divided by this.
  double split_shrink = 1.6;

  // Gaussians with a lower opacity are removed.
  double min_opacity = 0.005;

  // Blur split: a Gaussian that had the largest weight at more than this share
  // of the pixels of one picture is split, whatever its gradient and size. Such
  // a Gaussian blurs detail that its own gradient does not show. 0 splits none;
  // Mini-Splatting uses 1/5000.
  double blur_split_share = 0;

  // The largest number of Gaussians that cloning and splitting may lead to; 0
  // is no limit. When there is not room for all, blur splits come first, by
  // falling share, then the others, by falling gradient.
  int64_t max_gaussians = 0;

  Status Check() const;
};

// Changes the model and the moments of the optimiser together, and resets the
// statistics. The Gaussians that are kept come first, in their old order and
// with their moments. The clones follow, then the parts of splits, both in the
// order of their originals and with moments of zero. Random numbers are a
// function of seed, iteration and the old index of the Gaussian, so the result
// does not depend on threads or interruptions. `scene_extent` is in the units
// of the model frame, see SceneExtent.
void Densify(const DensificationOptions& options,
             double scene_extent,
             uint64_t seed,
             int64_t iteration,
             GaussianModel* model,
             Adam* adam,
             DensificationStatistics* statistics);

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_DENSITY_DENSIFICATION_H_
