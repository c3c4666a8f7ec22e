// SPDX-License-Identifier: BSD-3-Clause

#include "stages/evaluation.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>
#include <system_error>
#include <utility>

#include "core/image_io.h"
#include "semantics/box_iou.h"
#include "semantics/instance_metrics.h"
#include "splat/holdout.h"
#include "splat/image_metrics.h"
#include "splat/renderer.h"
#include "splat/training_images.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;

double Mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

std::optional<double> MeanOrNothing(const std::vector<double>& values) {
  if (values.empty()) return std::nullopt;
  return Mean(values);
}

void FillMeans(ImageQuality* quality) {
  for (const ImageQuality::ViewQuality& view : quality->views) {
    quality->psnr += view.psnr;
    quality->ssim += view.ssim;
  }
  quality->psnr /= static_cast<double>(quality->views.size());
  quality->ssim /= static_cast<double>(quality->views.size());
}

Status Cancelled() { return InterruptedError("evaluation interrupted"); }

// What is gathered about one object of the truth, view by view.
struct ObjectTally {
  std::vector<double> instance_ious;
  std::vector<double> click_ious;
};

// Judges one view: `truth` against `rendered`, both of the same size.
Status TallyView(const ImageU16& truth,
                 const Image<int32_t>& rendered,
                 const std::string& name,
                 int min_pixels,
                 semantics::InstanceOverlap* sum,
                 std::map<int, ObjectTally>* tallies) {
  StatusOr<semantics::InstanceOverlap> overlap =
      semantics::CountOverlap(truth, rendered);
  if (!overlap.ok()) return overlap.status().Annotated(name);
  for (const auto& [object, pixels] : overlap->truth_pixels) {
    if (pixels < min_pixels) continue;
    ObjectTally& tally = (*tallies)[object];
    const auto best = semantics::BestMatch(*overlap, object);
    tally.instance_ious.push_back(best ? best->iou : 0);
    const auto click = semantics::ClickPoint(truth, object);
    const int clicked = rendered(click->x(), click->y());
    tally.click_ious.push_back(clicked < 0 ? 0 : overlap->Iou(object, clicked));
  }
  sum->Add(*overlap);
  return Status();
}

// Box of each instance in the truth's frame.
std::vector<semantics::Instance> InstancesInTruth(
    const splat::GaussianModel& model,
    std::span<const int32_t> instance_of_gaussian,
    const Sim3d& truth_from_scene,
    const semantics::InstanceBoxOptions& options,
    ThreadPool& pool) {
  splat::GaussianModel
      moved;  // All but the colours: boxes do not ask for them.
  moved.Resize(model.size());
  moved.opacity_logits = model.opacity_logits;
  const auto log_scale = static_cast<float>(std::log(truth_from_scene.scale));
  int num_labels = 0;
  for (size_t i = 0; i < model.size(); ++i) {
    const Eigen::Vector3d mean =
        truth_from_scene * Eigen::Vector3d(model.means[3 * i],
                                           model.means[3 * i + 1],
                                           model.means[3 * i + 2]);
    for (int k = 0; k < 3; ++k) {
      moved.means[3 * i + k] = static_cast<float>(mean[k]);
      moved.log_scales[3 * i + k] = model.log_scales[3 * i + k] + log_scale;
    }
    const Eigen::Quaterniond rotation =
        truth_from_scene.rotation *
        Eigen::Quaterniond(model.rotations[4 * i],
                           model.rotations[4 * i + 1],
                           model.rotations[4 * i + 2],
                           model.rotations[4 * i + 3]);
    moved.rotations[4 * i] = static_cast<float>(rotation.w());
    moved.rotations[4 * i + 1] = static_cast<float>(rotation.x());
    moved.rotations[4 * i + 2] = static_cast<float>(rotation.y());
    moved.rotations[4 * i + 3] = static_cast<float>(rotation.z());
    num_labels = std::max(num_labels, instance_of_gaussian[i] + 1);
  }
  return semantics::BuildInstances(moved,
                                   instance_of_gaussian,
                                   num_labels,
                                   /*scores=*/{},
                                   /*background=*/{},
                                   /*vertical=*/std::nullopt,
                                   options,
                                   pool);
}

void FillBoxes(const std::vector<TrueObject>& objects,
               const semantics::InstanceOverlap& overlap,
               const std::vector<semantics::Instance>& instances,
               std::map<int, ObjectResult>* results,
               InstanceQuality* quality) {
  std::vector<double> ious;
  for (const TrueObject& object : objects) {
    ObjectResult& result = (*results)[object.id];
    result.label = object.label;
    double iou = 0;
    const auto match = semantics::BestMatch(overlap, object.id);
    if (match) {
      result.box = instances[static_cast<size_t>(match->instance)].aabb;
      iou = semantics::BoxIou(object.aabb, *result.box);
    }
    result.box_iou = iou;
    ious.push_back(iou);
  }
  if (ious.empty()) return;
  const auto recall = [&ious](double threshold) {
    const auto found = std::count_if(
        ious.begin(), ious.end(), [&](double v) { return v >= threshold; });
    return static_cast<double>(found) / static_cast<double>(ious.size());
  };
  quality->box_miou = Mean(ious);
  quality->box_recall25 = recall(0.25);
  quality->box_recall50 = recall(0.5);
}

}  // namespace

Status EvaluationOptions::Check() const {
  if (min_mask_pixels < 1) {
    return InvalidArgumentError("min_mask_pixels must be at least 1");
  }
  return Status();
}

StatusOr<sfm::PoseAlignment> AlignWithTruth(const WorkspaceScene& scene,
                                            const GroundTruth& truth) {
  sfm::NamedPoses target;
  std::map<std::string, std::vector<std::string>> names_by_stem;
  for (const View& view : truth.cameras.train) {
    target[view.name] = view.cam_from_world;
    names_by_stem[fs::path(view.name).stem().string()].push_back(view.name);
  }
  sfm::NamedPoses source;
  std::vector<const View*> without_match;
  for (const std::vector<View>* views : {&scene.train, &scene.holdout}) {
    for (const View& view : *views) {
      if (target.contains(view.name)) {
        source[view.name] = view.cam_from_world;
      } else {
        without_match.push_back(&view);
      }
    }
  }
  for (const View* view : without_match) {
    const auto found = names_by_stem.find(fs::path(view->name).stem().string());
    // A stem that several photos share says nothing.
    if (found != names_by_stem.end() && found->second.size() == 1) {
      source.emplace(found->second[0], view->cam_from_world);
    }
  }
  StatusOr<sfm::PoseAlignment> alignment = sfm::AlignPoses(source, target);
  if (!alignment.ok()) {
    return alignment.status().Annotated("aligning the scene with " +
                                        (truth.folder / "gt").string());
  }
  return alignment;
}

std::vector<View> MapViews(const std::vector<View>& truth_views,
                           const Sim3d& truth_from_scene) {
  const Sim3d scene_from_truth = Inverse(truth_from_scene);
  std::vector<View> views = truth_views;
  for (View& view : views) {
    view.cam_from_world =
        TransformCamera(scene_from_truth, view.cam_from_world);
  }
  return views;
}

StatusOr<std::optional<ImageQuality>> MeasureHoldoutQuality(
    const WorkspaceScene& scene,
    const fs::path& photos_folder,
    ThreadPool& pool) {
  if (scene.holdout.empty()) return std::optional<ImageQuality>();
  splat::TrainingImagesOptions options;
  options.max_side = scene.training_max_side;
  options.num_levels = 1;
  FREEGS_ASSIGN_OR_RETURN(
      splat::TrainingImages images,
      splat::TrainingImages::Load(scene.holdout, photos_folder, options, pool));
  FREEGS_ASSIGN_OR_RETURN(
      const splat::HoldoutReport report,
      splat::MeasureHoldout(scene.model, scene.render, &images, pool));
  ImageQuality quality;
  for (const splat::HoldoutView& view : report.views) {
    quality.views.push_back({view.name, view.psnr, view.ssim});
  }
  FillMeans(&quality);
  return std::optional(std::move(quality));
}

StatusOr<std::optional<ImageQuality>> MeasureTestQuality(
    const WorkspaceScene& scene,
    const GroundTruth& truth,
    const Sim3d& truth_from_scene,
    const CancellationToken& cancellation,
    ThreadPool& pool) {
  ImageQuality quality;
  std::error_code error;
  for (const View& view : MapViews(truth.cameras.test, truth_from_scene)) {
    const fs::path path = truth.TestPhoto(view);
    if (!fs::exists(path, error)) continue;
    if (cancellation.cancelled()) return Cancelled();
    FREEGS_ASSIGN_OR_RETURN(const ImageU8 photo, ReadRgb(path));
    const splat::RenderedView rendered = splat::RenderView(
        scene.model, view.camera, view.cam_from_world, scene.render, pool);
    // As a file would have it.
    const ImageF picture = ToFloat(ToU8(rendered.color));
    const StatusOr<double> psnr = splat::Psnr(picture, ToFloat(photo));
    if (!psnr.ok()) {
      return BadInputError(path.string() + ": " + psnr.status().message());
    }
    FREEGS_ASSIGN_OR_RETURN(const double ssim,
                            splat::Ssim(picture, ToFloat(photo)));
    quality.views.push_back({view.name, *psnr, ssim});
  }
  if (quality.views.empty()) return std::optional<ImageQuality>();
  FillMeans(&quality);
  return std::optional(std::move(quality));
}

StatusOr<std::optional<InstanceQuality>> MeasureInstanceQuality(
    const WorkspaceScene& scene,
    std::span<const int32_t> instance_of_gaussian,
    const GroundTruth& truth,
    const Sim3d& truth_from_scene,
    const EvaluationOptions& options,
    const CancellationToken& cancellation,
    ThreadPool& pool) {
  FREEGS_RETURN_IF_ERROR(options.Check());
  if (instance_of_gaussian.size() != scene.model.size()) {
    return BadInputError(
        "instances of " + std::to_string(instance_of_gaussian.size()) +
        " Gaussians for a scene of " + std::to_string(scene.model.size()));
  }
  std::error_code error;
  semantics::InstanceOverlap overlap;
  std::map<int, ObjectTally> tallies;
  bool any_view = false;
  for (const View& view : MapViews(truth.cameras.test, truth_from_scene)) {
    const fs::path path = truth.InstanceMap(view);
    if (!fs::exists(path, error)) continue;
    if (cancellation.cancelled()) return Cancelled();
    FREEGS_ASSIGN_OR_RETURN(const ImageU16 masks, ReadLabels(path));
    const Image<int32_t> rendered = splat::RenderLabels(scene.model,
                                                        view.camera,
                                                        view.cam_from_world,
                                                        scene.render,
                                                        pool,
                                                        instance_of_gaussian);
    FREEGS_RETURN_IF_ERROR(TallyView(masks,
                                     rendered,
                                     path.string(),
                                     options.min_mask_pixels,
                                     &overlap,
                                     &tallies));
    any_view = true;
  }
  if (!any_view) return std::optional<InstanceQuality>();

  InstanceQuality quality;
  std::vector<double> instance_ious;
  std::vector<double> click_ious;
  std::map<int, ObjectResult> results;
  for (const auto& [object, tally] : tallies) {
    ObjectResult& result = results[object];
    result.num_views = static_cast<int>(tally.instance_ious.size());
    result.instance_iou = MeanOrNothing(tally.instance_ious);
    result.click_iou = MeanOrNothing(tally.click_ious);
    instance_ious.insert(instance_ious.end(),
                         tally.instance_ious.begin(),
                         tally.instance_ious.end());
    click_ious.insert(
        click_ious.end(), tally.click_ious.begin(), tally.click_ious.end());
  }
  quality.instance_miou = MeanOrNothing(instance_ious);
  quality.click_miou = MeanOrNothing(click_ious);
  FillBoxes(truth.objects,
            overlap,
            InstancesInTruth(scene.model,
                             instance_of_gaussian,
                             truth_from_scene,
                             options.boxes,
                             pool),
            &results,
            &quality);
  for (auto& [id, result] : results) {
    result.id = id;
    const auto match = semantics::BestMatch(overlap, id);
    if (match) result.instance = match->instance;
    quality.objects.push_back(std::move(result));
  }
  return std::optional(std::move(quality));
}

}  // namespace freegs::stages
