// SPDX-License-Identifier: BSD-3-Clause
// Candidates, their estimation, and the choice.

#include "sfm/calibration/camera_selection.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "core/parallel.h"
#include "core/quantile.h"
#include "core/random.h"
#include "sfm/calibration/bundle_adjustment.h"
#include "sfm/calibration/photo_sample.h"
#include "sfm/scene/camera_conversion.h"
#include "sfm/scene/track_filter.h"

namespace freegs::sfm {
namespace {

constexpr size_t kMinPerImage = 40;
constexpr size_t kMinHeldOut = 50;
constexpr int kSelectionIterations = 30;

// The model is near its optimum already. With 1e-5, no camera of 292 photos
// ends more than 0.0006 degrees elsewhere; but near ties between lens models
// may be decided otherwise.
constexpr double kFunctionTolerance = 1e-4;

// Share of the observations that are held out from the estimation.
constexpr double kHeldOutShare = 0.15;

// A candidate explains unseen observations as well as another when its held-out
// error is larger by at most this share of it, or by at most so many pixels.
constexpr double kTolerance = 0.01;
constexpr double kTolerancePx = 0.01;

// A smaller difference in BIC tells nothing. Of pinhole cameras that were
// drawn, lenses with more parameters seemed better by up to 19, because errors
// of neighbouring features are not independent. Of real lenses the simpler ones
// were worse by 170 or more.
constexpr double kTellingBic = 50;

// A camera per photo must lower the held-out error by this share.
constexpr double kPerPhotoGain = 0.1;

// What all candidates are estimated from and measured on.
struct Sample {
  Reconstruction training;  // Chosen points, without the held-out observations.
  struct HeldOut {
    size_t image = 0;  // Position in training.images.
    size_t point = 0;  // Position in training.points3d.
    Eigen::Vector2d xy;
  };
  std::vector<HeldOut> held_out;
  size_t observations = 0;
};

// Points in an order that looks random and depends on nothing but their ids.
std::vector<size_t> Shuffled(const Reconstruction& model) {
  std::vector<size_t> order(model.points3d.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::sort(order.begin(), order.end(), [&](size_t a, size_t b) {
    const uint64_t id_a = model.points3d[a].id;
    const uint64_t id_b = model.points3d[b].id;
    return std::pair(RandomBits(1, 0, id_a), id_a) <
           std::pair(RandomBits(1, 0, id_b), id_b);
  });
  return order;
}

Sample DrawSample(const Reconstruction& model,
                  const CameraSelectionOptions& options) {
  Sample sample;
  sample.training.cameras = model.cameras;
  for (const PosedImage& image : model.images) {
    PosedImage& copy = sample.training.images.emplace_back();
    copy.id = image.id;
    copy.camera_id = image.camera_id;
    copy.name = image.name;
    copy.cam_from_world = image.cam_from_world;
  }
  const auto index = IndexImages(model);
  std::vector<size_t> per_image(model.images.size(), 0);
  for (const size_t p : Shuffled(model)) {
    const Point3D& point = model.points3d[p];
    if (point.track.size() < 2) continue;
    const bool needed =
        sample.observations < options.max_observations ||
        std::any_of(point.track.begin(), point.track.end(), [&](const auto& e) {
          return per_image[index.at(e.image_id)] < kMinPerImage;
        });
    if (!needed) continue;
    Point3D copy;
    copy.id = point.id;
    copy.xyz = point.xyz;
    const size_t position = sample.training.points3d.size();
    size_t left = point.track.size();
    for (size_t k = 0; k < point.track.size(); ++k) {
      const TrackElement& element = point.track[k];
      const size_t i = index.at(element.image_id);
      const Eigen::Vector2d& xy =
          model.images[i].points2d[element.point2d_index].xy;
      // Two observations are left, or the point has no place.
      if (left > 2 && RandomUniform(2, point.id, k) < kHeldOutShare) {
        sample.held_out.push_back({i, position, xy});
        --left;
        continue;
      }
      PosedImage& image = sample.training.images[i];
      copy.track.push_back(
          {image.id, static_cast<uint32_t>(image.points2d.size())});
      image.points2d.push_back({xy, point.id});
      ++per_image[i];
    }
    sample.observations += copy.track.size();
    sample.training.points3d.push_back(std::move(copy));
  }
  return sample;
}

std::vector<CameraCandidate> ListCandidates(
    const Reconstruction& model, const CameraSelectionOptions& options) {
  std::vector<CameraCandidate> candidates;
  std::vector<size_t> seen;  // Numbers of cameras: coarser sharings come first.
  const auto add = [&](bool wanted, CameraSharing sharing, bool all_models) {
    const size_t count = NumCameras(model, sharing);
    if (!wanted || std::find(seen.begin(), seen.end(), count) != seen.end()) {
      return;
    }
    seen.push_back(count);
    for (const CameraModel camera_model : options.models) {
      if (!all_models && camera_model != CameraModel::kSimplePinhole &&
          camera_model != CameraModel::kSimpleRadial) {
        continue;
      }
      CameraCandidate& candidate = candidates.emplace_back();
      candidate.model = camera_model;
      candidate.sharing = sharing;
      candidate.parameters = static_cast<int>(count) *
                             (GetCameraModel(camera_model).num_params - 2);
    }
  };
  add(options.shared, CameraSharing::kShared, true);
  add(options.per_group, CameraSharing::kPerGroup, true);
  add(options.per_photo, CameraSharing::kPerPhoto, seen.empty());
  std::stable_sort(candidates.begin(),
                   candidates.end(),
                   [](const CameraCandidate& a, const CameraCandidate& b) {
                     return a.parameters < b.parameters;
                   });
  return candidates;
}

// Distances in pixels between projections and what was observed.
struct Residuals {
  std::vector<double> training;
  std::vector<double> held_out;
};

double Distance(const Reconstruction& model,
                const std::vector<size_t>& camera_of_image,
                size_t image,
                size_t point,
                const Eigen::Vector2d& xy) {
  const auto pixel =
      Project(model.cameras[camera_of_image[image]],
              model.images[image].cam_from_world * model.points3d[point].xyz);
  return pixel ? (*pixel - xy).norm() : std::numeric_limits<double>::infinity();
}

Residuals Measure(const Reconstruction& model, const Sample& sample) {
  const auto image_index = IndexImages(model);
  const auto camera_index = IndexCameras(model);
  std::vector<size_t> cameras;
  for (const PosedImage& image : model.images) {
    cameras.push_back(camera_index.at(image.camera_id));
  }
  Residuals residuals;
  for (size_t p = 0; p < model.points3d.size(); ++p) {
    for (const TrackElement& element : model.points3d[p].track) {
      const size_t i = image_index.at(element.image_id);
      residuals.training.push_back(
          Distance(model,
                   cameras,
                   i,
                   p,
                   model.images[i].points2d[element.point2d_index].xy));
    }
  }
  for (const Sample::HeldOut& held : sample.held_out) {
    residuals.held_out.push_back(
        Distance(model, cameras, held.image, held.point, held.xy));
  }
  return residuals;
}

double TruncatedRms(const std::vector<double>& values, double limit) {
  double sum = 0;
  for (const double value : values) {
    const double cut = std::min(value, limit);
    sum += cut * cut;
  }
  return std::sqrt(sum / static_cast<double>(values.size()));
}

// Fills in `candidate`, apart from what depends on the other candidates.
void Estimate(const Sample& sample,
              const CancellationToken* cancellation,
              CameraCandidate* candidate,
              Residuals* residuals) {
  Reconstruction model = sample.training;
  AssignCameras(candidate->model, candidate->sharing, &model);
  BundleAdjustmentOptions adjustment;
  adjustment.max_iterations = kSelectionIterations;
  adjustment.function_tolerance = kFunctionTolerance;
  adjustment.cancellation = cancellation;
  const Status adjusted = AdjustBundle(adjustment, &model);
  if (!adjusted.ok()) {
    candidate->refused = adjusted.message();
    return;
  }
  *residuals = Measure(model, sample);
  candidate->held_out_median_px = UpperMedian(residuals->held_out);
  for (const Camera& camera : model.cameras) {
    const Status lens = CheckLens(camera);
    if (!lens.ok() && candidate->refused.empty()) {
      candidate->refused =
          "camera " + std::to_string(camera.id) + ": " + lens.message();
    }
  }
  candidate->cameras = std::move(model.cameras);
}

// Errors and BIC of all candidates, with one limit for residuals.
void Score(const std::vector<Residuals>& residuals,
           std::vector<CameraCandidate>* candidates) {
  double median = std::numeric_limits<double>::infinity();
  for (const CameraCandidate& candidate : *candidates) {
    if (candidate.refused.empty()) {
      median = std::min(median, candidate.held_out_median_px);
    }
  }
  // The median of a Rayleigh distribution is 1.1774 standard deviations. The
  // least limit is for tracks without noise.
  const double limit = std::max(3 * std::sqrt(2.0) * median / 1.1774, 0.03);
  for (size_t i = 0; i < candidates->size(); ++i) {
    CameraCandidate& candidate = (*candidates)[i];
    if (candidate.cameras.empty()) continue;
    candidate.held_out_error_px = TruncatedRms(residuals[i].held_out, limit);
    candidate.rms_px = TruncatedRms(residuals[i].training, limit);
    const double n = 2.0 * static_cast<double>(residuals[i].training.size());
    const double variance = std::max(candidate.rms_px * candidate.rms_px, 1e-8);
    candidate.bic = n * std::log(variance) + candidate.parameters * std::log(n);
  }
}

constexpr size_t kNone = std::numeric_limits<size_t>::max();

// The best by BIC, or the simplest that is hardly less likely; among candidates
// that `eligible` takes and whose held-out error is about as small as any.
template <typename Predicate>
size_t Choose(const std::vector<CameraCandidate>& candidates,
              const Predicate& eligible) {
  double least_error = std::numeric_limits<double>::infinity();
  for (const CameraCandidate& candidate : candidates) {
    if (!eligible(candidate)) continue;
    least_error = std::min(least_error, candidate.held_out_error_px);
  }
  const double good_enough =
      std::max(least_error * (1 + kTolerance), least_error + kTolerancePx);
  const auto is_good = [&](const CameraCandidate& candidate) {
    return eligible(candidate) && candidate.held_out_error_px <= good_enough;
  };
  double least_bic = std::numeric_limits<double>::infinity();
  for (const CameraCandidate& candidate : candidates) {
    if (is_good(candidate)) least_bic = std::min(least_bic, candidate.bic);
  }
  size_t best = kNone;
  for (size_t i = 0; i < candidates.size(); ++i) {
    const CameraCandidate& candidate = candidates[i];
    if (!is_good(candidate) || candidate.bic > least_bic + kTellingBic) {
      continue;
    }
    if (best == kNone ||
        std::pair(candidate.parameters, candidate.bic) <
            std::pair(candidates[best].parameters, candidates[best].bic)) {
      best = i;
    }
  }
  return best;
}

Status ChooseBest(CameraSelection* selection) {
  const std::vector<CameraCandidate>& candidates = selection->candidates;
  const auto usable = [](const CameraCandidate& candidate) {
    return candidate.refused.empty();
  };
  const auto several = [&](const CameraCandidate& candidate) {
    return usable(candidate) && candidate.sharing != CameraSharing::kPerPhoto;
  };
  size_t chosen = Choose(candidates, several);
  const size_t any = Choose(candidates, usable);
  if (chosen == kNone ||
      (candidates[any].held_out_error_px <
           candidates[chosen].held_out_error_px * (1 - kPerPhotoGain) &&
       candidates[any].bic < candidates[chosen].bic)) {
    chosen = any;
  }
  if (chosen == kNone) {
    return UnusableResultError(
        "no camera model fits: " +
        (candidates.empty() ? "none was tried" : candidates[0].refused));
  }
  selection->chosen = chosen;
  selection->candidates[chosen].chosen = true;
  return {};
}

}  // namespace

Status CameraSelectionOptions::Check() const {
  if (models.empty() || !std::all_of(models.begin(), models.end(), CanAdjust) ||
      !(shared || per_group || per_photo)) {
    return InvalidArgumentError(
        "camera selection needs at least one sharing, and models that bundle "
        "adjustment knows");
  }
  if (max_images < 3) {
    return InvalidArgumentError("camera selection needs at least three images");
  }
  return {};
}

StatusOr<CameraSelection> SelectCameras(const Reconstruction& model,
                                        const CameraSelectionOptions& options) {
  FREEGS_RETURN_IF_ERROR(options.Check());
  FREEGS_RETURN_IF_ERROR(CheckReconstruction(model));
  if (model.images.size() < 3) {
    return UnusableResultError(
        "choosing a camera model needs at least three photos with a pose");
  }
  Reconstruction clean = model;
  RemoveDanglingReferences(&clean);
  clean = SamplePhotos(clean, options.max_images);
  const Sample sample = DrawSample(clean, options);
  if (sample.held_out.size() < kMinHeldOut) {
    return UnusableResultError(
        "choosing a camera model needs points that three photos see: there "
        "are only " +
        std::to_string(sample.held_out.size()) + " observations to judge by");
  }
  CameraSelection selection;
  selection.images = clean.images.size();
  selection.observations = sample.observations;
  selection.held_out = sample.held_out.size();
  selection.candidates = ListCandidates(clean, options);
  std::vector<Residuals> residuals(selection.candidates.size());
  ThreadPool pool(options.num_threads);
  // The costly ones first.
  const int64_t count = static_cast<int64_t>(residuals.size());
  pool.ParallelFor(0, count, 1, [&](int64_t first, int64_t last, int) {
    for (int64_t k = first; k < last; ++k) {
      const int64_t i = count - 1 - k;
      Estimate(sample,
               options.cancellation,
               &selection.candidates[i],
               &residuals[i]);
    }
  });
  if (IsCancelled(options.cancellation)) {
    return InterruptedError("stopped on request");
  }
  Score(residuals, &selection.candidates);
  FREEGS_RETURN_IF_ERROR(ChooseBest(&selection));
  return selection;
}

StatusOr<CameraSelection> RefineCameras(const CameraSelectionOptions& options,
                                        Reconstruction* model) {
  FREEGS_ASSIGN_OR_RETURN(CameraSelection selection,
                          SelectCameras(*model, options));
  const CameraCandidate& chosen = selection.candidates[selection.chosen];
  Reconstruction refined = *model;
  RemoveDanglingReferences(&refined);
  AssignCameras(chosen.model, chosen.sharing, &refined);
  BundleAdjustmentOptions adjustment;
  adjustment.function_tolerance = kFunctionTolerance;
  adjustment.cancellation = options.cancellation;
  FREEGS_RETURN_IF_ERROR(AdjustBundle(adjustment, &refined));
  FilterTracks(&refined);
  FREEGS_RETURN_IF_ERROR(AdjustBundle(adjustment, &refined));
  FilterTracks(&refined);
  for (const Camera& camera : refined.cameras) {
    FREEGS_RETURN_IF_ERROR(CheckLens(camera));
  }
  *model = std::move(refined);
  return selection;
}

StatusOr<CameraSelection> RefineCamerasAgain(
    const CameraSelectionOptions& options,
    const CameraGroups& groups,
    Reconstruction* model) {
  // Cameras that photos share again explain the model badly until they are
  // adjusted, so the model itself must not get them before that.
  Reconstruction refined = *model;
  RestoreCameraGroups(groups, &refined);
  FREEGS_ASSIGN_OR_RETURN(CameraSelection selection,
                          RefineCameras(options, &refined));
  *model = std::move(refined);
  return selection;
}

}  // namespace freegs::sfm
