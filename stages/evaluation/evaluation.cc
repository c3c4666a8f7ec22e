// SPDX-License-Identifier: BSD-3-Clause

#include "stages/evaluation/evaluation.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <utility>

#include "core/io/image_io.h"
#include "sfm/import/name_matching.h"
#include "splat/images/holdout.h"
#include "splat/images/training_images.h"
#include "splat/optim/image_metrics.h"
#include "splat/render/renderer.h"
#include "stages/scene/scene_alignment.h"
#include "stages/scene/training_scene.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;

void FillMeans(ImageQuality* quality) {
  for (const ImageQuality::ViewQuality& view : quality->views) {
    quality->psnr += view.psnr;
    quality->ssim += view.ssim;
  }
  quality->psnr /= static_cast<double>(quality->views.size());
  quality->ssim /= static_cast<double>(quality->views.size());
}

bool IsSameView(const View& a, const View& b) {
  return a.name == b.name &&
         a.cam_from_world.rotation.isApprox(b.cam_from_world.rotation) &&
         a.cam_from_world.translation.isApprox(b.cam_from_world.translation);
}

Status Cancelled() { return InterruptedError("evaluation interrupted"); }

}  // namespace

std::vector<TestViewUse> FindTestViewUses(const WorkspaceScene& scene,
                                          const GroundTruth& truth) {
  const std::vector<View>& test = truth.cameras.test;
  std::vector<sfm::SfmPhoto> views;
  for (const View& view : test) views.emplace_back().name = view.name;
  std::map<std::string, const View*> test_by_name;
  for (const View& view : test) test_by_name[view.name] = &view;
  for (const View& view : truth.cameras.train) {
    // Some data sets count their test views among the training views.
    const auto same = test_by_name.find(view.name);
    if (same != test_by_name.end() && IsSameView(view, *same->second)) continue;
    views.emplace_back().name = view.name;
  }
  std::vector<std::string> names;
  for (const View& view : scene.train) names.push_back(view.name);
  for (const View& view : scene.holdout) names.push_back(view.name);
  const std::vector<int> matches = sfm::MatchNames(names, views).photos;
  std::vector<TestViewUse> uses(test.size(), TestViewUse::kNone);
  for (size_t i = 0; i < matches.size(); ++i) {
    if (matches[i] < 0 || matches[i] >= std::ssize(test)) continue;
    uses[static_cast<size_t>(matches[i])] =
        i < scene.train.size() ? TestViewUse::kTraining : TestViewUse::kHoldout;
  }
  return uses;
}

size_t ImageQuality::Count(TestViewUse use) const {
  return static_cast<size_t>(
      std::count_if(views.begin(), views.end(), [use](const ViewQuality& view) {
        return view.use == use;
      }));
}

StatusOr<std::optional<ImageQuality>> MeasureHoldoutQuality(
    const WorkspaceScene& scene,
    const fs::path& photos_folder,
    const fs::path& mask_folder,
    const CancellationToken& cancellation,
    ThreadPool& pool) {
  if (scene.holdout.empty()) return std::optional<ImageQuality>();
  splat::TrainingImagesOptions options;
  options.max_side = scene.training_max_side;
  options.num_levels = 1;
  options.mask_folder = mask_folder;
  FREEGS_ASSIGN_OR_RETURN(
      splat::TrainingImages images,
      splat::TrainingImages::Load(scene.holdout, photos_folder, options, pool));
  FREEGS_ASSIGN_OR_RETURN(const splat::HoldoutReport report,
                          splat::MeasureHoldout({.model = scene.model,
                                                 .render = scene.render,
                                                 .images = &images,
                                                 .exposures = scene.exposures,
                                                 .cancellation = &cancellation},
                                                pool));
  if (report.views.empty()) return std::optional<ImageQuality>();
  ImageQuality quality;
  for (const splat::HoldoutView& view : report.views) {
    quality.views.push_back({.name = view.name,
                             .psnr = view.psnr,
                             .ssim = view.ssim,
                             .use = TestViewUse::kHoldout});
  }
  FillMeans(&quality);
  return std::optional(std::move(quality));
}

StatusOr<std::optional<ImageQuality>> MeasureTestQuality(
    const EvaluationContext& context) {
  const WorkspaceScene& scene = context.scene;
  const GroundTruth& truth = context.truth;
  ImageQuality quality;
  const std::vector<TestViewUse> uses = FindTestViewUses(scene, truth);
  const std::vector<View> views =
      MapViews(truth.cameras.test, context.truth_from_scene);
  for (size_t i = 0; i < views.size(); ++i) {
    const View& view = views[i];
    const auto found = truth.photos.find(view.name);
    if (found == truth.photos.end()) continue;
    const fs::path& path = found->second;
    if (context.cancellation.cancelled()) return Cancelled();
    FREEGS_ASSIGN_OR_RETURN(const ImageU8 photo, ReadRgb(path));
    // Before the rendering, for which a wrong size may need too much memory.
    if (photo.width() != view.camera.width ||
        photo.height() != view.camera.height) {
      return BadInputError(
          path.string() + ": is " + std::to_string(photo.width()) + " x " +
          std::to_string(photo.height()) + " pixels, but test view " +
          view.name + " of the truth is " + std::to_string(view.camera.width) +
          " x " + std::to_string(view.camera.height));
    }
    const splat::RenderedView rendered = splat::RenderView(scene.model,
                                                           view.camera,
                                                           view.cam_from_world,
                                                           scene.render,
                                                           context.pool);
    // PSNR is defined on 8-bit pictures.
    const ImageF picture = ToFloat(ToU8(rendered.color));
    FREEGS_ASSIGN_OR_RETURN(const double psnr,
                            splat::Psnr(picture, ToFloat(photo)));
    FREEGS_ASSIGN_OR_RETURN(const double ssim,
                            splat::Ssim(picture, ToFloat(photo)));
    quality.views.push_back({view.name, psnr, ssim, uses[i]});
  }
  if (quality.views.empty()) return std::optional<ImageQuality>();
  FillMeans(&quality);
  return std::optional(std::move(quality));
}

}  // namespace freegs::stages
