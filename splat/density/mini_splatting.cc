// SPDX-License-Identifier: BSD-3-Clause

#include "splat/density/mini_splatting.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "core/random.h"
#include "splat/density/depth_reinitialization.h"
#include "splat/density/simplification.h"

namespace freegs::splat {
namespace {

// Random number streams; see core/random.h.
constexpr uint64_t kDepthStream = 0x6465707468;       // "depth"
constexpr uint64_t kSimplifyStream = 0x73696d706c65;  // "simple"

// The paper draws 3.5 million points and has at most 4.5 million Gaussians.
constexpr double kDepthShareOfDense = 7.0 / 9;
constexpr uint64_t kMaxDepthPoints = 3500000;
constexpr uint64_t kPixelsPerDepthPoint = 32;

uint64_t StreamOf(uint64_t purpose, const MiniSplattingContext& context) {
  return MixBits(MixBits(purpose) ^ static_cast<uint64_t>(context.iteration));
}

// Computes what each Gaussian contributes to view i, without the pixels that
// its mask ignores. Fetches the photo of the view to *photo. Where photo is
// null nobody looks at it, and it is fetched only if there may be a mask, which
// comes with the photo. kInterrupted when cancelled.
Status RenderContributions(const MiniSplattingContext& context,
                           const GaussianModel& model,
                           size_t i,
                           ImageF* photo,
                           ViewContributions* contributions) {
  if (IsCancelled(context.cancellation)) {
    return InterruptedError("training: stopped in the milestone at iteration " +
                            std::to_string(context.iteration));
  }
  TrainingImages& images = *context.images;
  const View view = images.view(i, context.level);
  ImageF unseen;
  if (photo != nullptr || images.may_have_masks()) {
    FREEGS_RETURN_IF_ERROR(
        images.Fetch(i, context.level, photo != nullptr ? photo : &unseen));
  }
  context.rasterizer->Contributions(model,
                                    view.camera,
                                    view.cam_from_world,
                                    context.render,
                                    images.Mask(i, context.level),
                                    *context.pool,
                                    contributions);
  return Status();
}

Status NothingVisible(std::string_view what, size_t count) {
  return UnusableResultError(std::string(what) + ": none of the " +
                             std::to_string(count) +
                             " Gaussians is visible in any training photo; "
                             "check the camera poses, the 3D points and the "
                             "masks");
}

}  // namespace

Status MiniSplattingOptions::Check() const {
  if (!(blur_split_share >= 0 && blur_split_share < 1)) {
    return InvalidArgumentError("blur_split_share must be in [0, 1)");
  }
  if (!(dense_factor >= 1 && std::isfinite(dense_factor))) {
    return InvalidArgumentError("dense_factor must be at least 1");
  }
  if (!(simplify_slack >= 1 && std::isfinite(simplify_slack))) {
    return InvalidArgumentError("simplify_slack must be at least 1");
  }
  if (!(simplify_keep > 0 && simplify_keep <= 1)) {
    return InvalidArgumentError("simplify_keep must be in (0, 1]");
  }
  if (!(prune_importance_share >= 0 && prune_importance_share < 1)) {
    return InvalidArgumentError("prune_importance_share must be in [0, 1)");
  }
  return Status();
}

StatusOr<std::vector<float>> ComputeImportance(
    const MiniSplattingContext& context,
    const GaussianModel& model,
    ImportanceMetric metric) {
  ImportanceAccumulator accumulator(model.size());
  ViewContributions contributions;
  for (size_t i = 0; i < context.images->size(); ++i) {
    FREEGS_RETURN_IF_ERROR(
        RenderContributions(context, model, i, nullptr, &contributions));
    accumulator.AddView(contributions);
  }
  return accumulator.Importance(metric);
}

size_t NumDepthPoints(const MiniSplattingOptions& options,
                      int64_t budget,
                      size_t num_gaussians,
                      uint64_t num_pixels) {
  if (budget > 0) {
    const double dense = options.dense_factor * static_cast<double>(budget);
    return static_cast<size_t>(std::ceil(kDepthShareOfDense * dense));
  }
  return std::min<uint64_t>(
      kMaxDepthPoints,
      std::max<uint64_t>(num_gaussians, num_pixels / kPixelsPerDepthPoint));
}

StatusOr<MiniSplattingSummary> ReinitializeFromDepth(
    const MiniSplattingOptions& options,
    int64_t budget,
    const MiniSplattingContext& context,
    GaussianModel* model,
    Adam* adam) {
  MiniSplattingSummary summary{model->size(), model->size()};
  TrainingImages& images = *context.images;
  ViewContributions contributions;
  std::vector<double> opacity(images.size());
  uint64_t num_pixels = 0;
  for (size_t i = 0; i < images.size(); ++i) {
    FREEGS_RETURN_IF_ERROR(
        RenderContributions(context, *model, i, nullptr, &contributions));
    opacity[i] = AccumulatedOpacity(contributions);
    num_pixels += contributions.dominant.num_pixels();
  }
  // Each view is rendered a second time instead of being kept: the renderings
  // of a thousand photos of a megapixel would take 8 GB.
  const std::vector<size_t> counts = PointsPerView(
      opacity, NumDepthPoints(options, budget, model->size(), num_pixels));
  DepthPoints points;
  ImageF photo;
  ImageF scene;  // The photo's colours as the scene has them.
  for (size_t i = 0; i < images.size(); ++i) {
    if (counts[i] == 0) continue;
    FREEGS_RETURN_IF_ERROR(
        RenderContributions(context, *model, i, &photo, &contributions));
    if (context.colors != nullptr && !context.colors->entries.empty()) {
      const AffineColor back = Inverse(context.colors->entries[i].color);
      ApplyColor(back, photo, *context.pool, &scene);
      std::swap(photo, scene);
    }
    FREEGS_ASSIGN_OR_RETURN(
        const DepthPoints drawn,
        SampleDepthPoints(*model,
                          images.view(i, context.level),
                          contributions,
                          photo,
                          context.render.near_plane,
                          counts[i],
                          context.seed,
                          MixBits(StreamOf(kDepthStream, context) ^ i)));
    points.Append(drawn);
  }
  if (points.size() == 0) return summary;
  FREEGS_ASSIGN_OR_RETURN(*model,
                          RestartFromDepthPoints(points, context.scene_extent));
  adam->Reset(*model);
  summary.after = model->size();
  return summary;
}

StatusOr<MiniSplattingSummary> Simplify(const MiniSplattingOptions& options,
                                        int64_t budget,
                                        ImportanceMetric metric,
                                        const MiniSplattingContext& context,
                                        GaussianModel* model,
                                        Adam* adam) {
  FREEGS_ASSIGN_OR_RETURN(const std::vector<float> importance,
                          ComputeImportance(context, *model, metric));
  const auto important = std::count_if(importance.begin(),
                                       importance.end(),
                                       [](float value) { return value > 0; });
  if (important == 0) return NothingVisible("simplification", model->size());
  const size_t count =
      budget > 0 ? static_cast<size_t>(budget)
                 : static_cast<size_t>(std::ceil(
                       options.simplify_keep * static_cast<double>(important)));
  const std::vector<uint32_t> kept = SampleByImportance(
      importance, count, context.seed, StreamOf(kSimplifyStream, context));
  const MiniSplattingSummary summary{model->size(), kept.size()};
  model->Select(kept);
  adam->Select(kept);
  return summary;
}

StatusOr<MiniSplattingSummary> PruneByImportance(
    const MiniSplattingOptions& options,
    int64_t budget,
    ImportanceMetric metric,
    const MiniSplattingContext& context,
    GaussianModel* model,
    Adam* adam) {
  FREEGS_ASSIGN_OR_RETURN(const std::vector<float> importance,
                          ComputeImportance(context, *model, metric));
  std::vector<uint32_t> kept =
      KeepCumulativeImportance(importance, 1 - options.prune_importance_share);
  if (budget > 0 && kept.size() > static_cast<size_t>(budget)) {
    kept = MostImportant(importance, static_cast<size_t>(budget));
  }
  if (kept.empty()) return NothingVisible("pruning", model->size());
  const MiniSplattingSummary summary{model->size(), kept.size()};
  model->Select(kept);
  adam->Select(kept);
  return summary;
}

}  // namespace freegs::splat
