// SPDX-License-Identifier: BSD-3-Clause
// The three operations of Mini-Splatting (Fang and Wang 2024) that change the
// whole model during training: depth reinitialisation, simplification and
// pruning.

#ifndef FREEGS_SPLAT_DENSITY_MINI_SPLATTING_H_
#define FREEGS_SPLAT_DENSITY_MINI_SPLATTING_H_

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/cancellation.h"
#include "core/parallel.h"
#include "core/status.h"
#include "splat/density/importance.h"
#include "splat/images/training_images.h"
#include "splat/optim/adam.h"
#include "splat/optim/exposure.h"
#include "splat/render/rasterizer.h"
#include "splat/render/renderer.h"
#include "splat/scene/gaussian_model.h"

namespace freegs::splat {

struct MiniSplattingOptions {
  // See DensificationOptions. The paper uses 1/5000 with pictures of about a
  // megapixel. In a small picture that is a few pixels, so nearly every
  // Gaussian would be split.
  double blur_split_share = 1.0 / 1000;

  // The model before the simplification may have this many times as many
  // Gaussians as the budget allows afterwards.
  double dense_factor = 2.0;

  // When there is no budget, the simplification keeps this share of the
  // Gaussians whose importance is not 0.
  double simplify_keep = 0.5;

  // When a pruning follows, the simplification keeps this many times as many
  // Gaussians as the budget allows, and the pruning removes the rest.
  double simplify_slack = 1.15;

  // Share of the total importance that the last pruning removes.
  double prune_importance_share = 0.01;

  Status Check() const;
};

// What all three operations need. Photos and views are taken at `level` of the
// image pyramid. When cancelled, they return kInterrupted and leave the model
// and its moments as they are.
struct MiniSplattingContext {
  TrainingImages* images = nullptr;
  // The learnt exposures of these photos; may be null.
  const PhotoColors* colors = nullptr;
  int level = 0;
  RenderOptions render;
  double scene_extent = 1;
  uint64_t seed = 0;
  int64_t iteration = 0;  // Random numbers depend on it.
  Rasterizer* rasterizer = nullptr;
  ThreadPool* pool = nullptr;
  const CancellationToken* cancellation = nullptr;  // May be null.
};

// The number of Gaussians before and after an operation.
struct MiniSplattingSummary {
  size_t before = 0;
  size_t after = 0;
};

// Returns the importance of every Gaussian over all views, without the pixels
// that masks ignore. Reads photos only where there may be masks, and fails when
// one of them has become unreadable, and with kInterrupted when cancelled.
StatusOr<std::vector<float>> ComputeImportance(
    const MiniSplattingContext& context,
    const GaussianModel& model,
    ImportanceMetric metric);

// Returns how many points to draw from the depth maps of all views together.
// With a budget they are 7/9 of the largest dense model, like the 3.5 of 4.5
// million in the paper; blur splits can add detail with the rest. Without a
// budget they are one for 32 pixels of the photos, but no fewer than there are
// Gaussians and no more than 3.5 million.
size_t NumDepthPoints(const MiniSplattingOptions& options,
                      int64_t budget,
                      size_t num_gaussians,
                      uint64_t num_pixels);

// Replaces the model by one that starts again from points on the surfaces that
// it shows, in the photos' colours without the exposure that was learnt, and
// with moments of zero. Renders each view twice. When no view shows anything
// the model and its moments stay as they are.
StatusOr<MiniSplattingSummary> ReinitializeFromDepth(
    const MiniSplattingOptions& options,
    int64_t budget,
    const MiniSplattingContext& context,
    GaussianModel* model,
    Adam* adam);

// Keeps `budget` Gaussians, drawn at random in proportion to their importance
// (SampleByImportance). A budget of 0 stands for the share simplify_keep. They
// keep their parameters and moments. In the paper they start again from their
// position and colour, which costs thousands of steps. Fails with
// kUnusableResult when no view shows any Gaussian.
StatusOr<MiniSplattingSummary> Simplify(const MiniSplattingOptions& options,
                                        int64_t budget,
                                        ImportanceMetric metric,
                                        const MiniSplattingContext& context,
                                        GaussianModel* model,
                                        Adam* adam);

// Removes the least important Gaussians, as many as together carry
// prune_importance_share of the total importance, and more when more than
// `budget` would be left (0 is no limit). The others keep their parameters and
// moments. Fails with kUnusableResult when no view shows any Gaussian.
StatusOr<MiniSplattingSummary> PruneByImportance(
    const MiniSplattingOptions& options,
    int64_t budget,
    ImportanceMetric metric,
    const MiniSplattingContext& context,
    GaussianModel* model,
    Adam* adam);

}  // namespace freegs::splat

#endif  // FREEGS_SPLAT_DENSITY_MINI_SPLATTING_H_
