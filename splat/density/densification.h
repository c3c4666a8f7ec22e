// SPDX-License-Identifier: BSD-3-Clause
// Adaptive density control of 3D Gaussian Splatting (Kerbl et al. 2023, section
// 5): clone, split, prune, and the reset of opacities. With the blur split of
// Mini-Splatting (Fang and Wang 2024, section 4.1).

#ifndef FREEGS_SPLAT_DENSITY_DENSIFICATION_H_
#define FREEGS_SPLAT_DENSITY_DENSIFICATION_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/image.h"
#include "core/status.h"
#include "splat/optim/adam.h"
#include "splat/scene/gaussian_model.h"

namespace freegs::splat {

// What densification remembers of each Gaussian since it last ran.
struct DensificationStatistics {
  // Sum over the steps that saw the Gaussian of |d loss / d projected mean|, in
  // the units of 3DGS: image coordinates that span [-1, 1].
  std::vector<float> gradient_sum;

  // Number of those steps.
  std::vector<uint32_t> visible_steps;

  // Largest projected radius in pixels.
  std::vector<float> max_radius;

  // Largest share of a picture's pixels at which the Gaussian had the largest
  // blending weight of all.
  std::vector<float> max_dominant_share;

  size_t size() const { return gradient_sum.size(); }

  // Zeros for `count` Gaussians.
  void Reset(size_t count);

  // Adds one step. `visible` lists the Gaussians seen (no repeats); entry k of
  // the other arrays belongs to visible[k]. pixel_gradients is
  // d loss / d projected mean in pixels, x and y interleaved; radii in pixels.
  void AddView(std::span<const uint32_t> visible,
               std::span<const float> pixel_gradients,
               std::span<const float> radii,
               int width,
               int height);

  // Adds one picture. `dominant` holds per pixel, H x W, the Gaussian of the
  // largest weight or -1, see ViewContributions. Time grows with the pixels,
  // not with the Gaussians.
  void AddDominant(const Image<int32_t>& dominant);

  // gradient_sum / visible_steps, 0 for a Gaussian never seen.
  float MeanGradient(size_t index) const {
    return visible_steps[index] == 0
               ? 0.0f
               : gradient_sum[index] / static_cast<float>(visible_steps[index]);
  }

  // Keeps the Gaussians listed; see GaussianModel::Select.
  void Select(std::span<const uint32_t> indices);

 private:
  std::vector<uint32_t> pixel_counts_;  // Scratch; zeros between calls.
};

struct DensificationOptions {
  // Gaussians whose mean gradient is at least this are cloned or split (units
  // of DensificationStatistics::gradient_sum).
  double gradient_threshold = 2e-4;

  // Up to this largest standard deviation a Gaussian is cloned, above it is
  // split; share of the scene extent.
  double clone_max_scale = 0.01;

  // A split replaces a Gaussian by two drawn from it, this much smaller.
  double split_shrink = 1.6;

  // Gaussians of less opacity are removed.
  double min_opacity = 0.005;

  // Gaussians with a larger standard deviation are removed; share of the scene
  // extent, 0 removes none. 3DGS uses 0.1 once opacities were reset.
  double max_scale = 0;

  // Gaussians that covered a larger radius in pixels are removed; 0 removes
  // none.
  double max_radius = 0;

  // Blur split: Gaussians that dominated more than this share of a picture's
  // pixels are split, whatever their gradient and small as they may be, for
  // they stand for detail that their own gradient does not ask for. 0 splits
  // none; Mini-Splatting uses 1/5000.
  double blur_split_share = 0;

  // No clones or splits beyond this number of Gaussians: blur splits go first,
  // those of the largest share leading, then those of the largest gradients. 0
  // is no limit.
  int64_t max_gaussians = 0;

  Status Check() const;
};

struct DensificationSummary {
  size_t cloned = 0;
  size_t split = 0;       // Gaussians replaced, each by two.
  size_t blur_split = 0;  // Those of them that were blur splits.
  size_t pruned = 0;      // Removed; those replaced by a split do not count.
  size_t total = 0;       // Gaussians afterwards.
};

// Edits model and optimiser together and resets the statistics. Afterwards come
// the Gaussians kept, in their old order and with their moments, then the
// clones, then the children of splits, both in the order of their originals,
// with zero moments. Random numbers are a function of (seed, iteration, index
// of the Gaussian before), so the result does not depend on threads or
// interruptions. `scene_extent` is in world units, see SceneExtent.
DensificationSummary Densify(const DensificationOptions& options,
                             double scene_extent,
                             uint64_t seed,
                             int64_t iteration,
                             GaussianModel* model,
                             Adam* adam,
                             DensificationStatistics* statistics);

// Lowers opacities above `max_opacity` to it and forgets their moments (3DGS:
// 0.01 every 3000 iterations, against floaters near the cameras).
void ResetOpacity(double max_opacity, GaussianModel* model, Adam* adam);

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_DENSITY_DENSIFICATION_H_
