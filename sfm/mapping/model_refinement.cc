// SPDX-License-Identifier: BSD-3-Clause

#include "sfm/mapping/model_refinement.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "sfm/mapping/initial_pair.h"
#include "sfm/mapping/place_comparison.h"
#include "sfm/mapping/separate_parts.h"

namespace freegs::sfm {

namespace fs = std::filesystem;

// Gives a model the simplest cameras that explain it, and adjusts it with them.
// If its cameras were chosen before, `groups` are the groups noted then; else
// it is null. If the model has too little to choose by, it keeps its cameras.
StatusOr<ModelRefinement::CameraChoice> ModelRefinement::ChooseCameras(
    const CameraGroups* groups, Reconstruction* model) const {
  if (context_.options.camera_model != "auto" || model->images.size() < 3) {
    return CameraChoice{};
  }
  context_.Report("camera model", 0, 1, "");
  CameraSelectionOptions options;
  options.shared = context_.options.camera != "per_image";
  options.per_group = options.per_photo = context_.options.camera == "auto";
  options.per_photo |= context_.options.camera == "per_image";
  options.num_threads = context_.num_threads;
  options.cancellation = context_.input.cancellation;
  auto selection = groups == nullptr
                       ? RefineCameras(options, model)
                       : RefineCamerasAgain(options, *groups, model);
  context_.Report("camera model", 1, 1, "");
  if (selection.ok()) return CameraChoice{std::move(selection->candidates), ""};
  if (selection.status().code() != StatusCode::kUnusableResult) {
    return selection.status();
  }
  return CameraChoice{{}, selection.status().message()};
}

bool ModelRefinement::AreOfNoUse(
    const SceneEvidence& evidence,
    const std::vector<Reconstruction>& models) const {
  const std::vector<Finding> findings = Diagnose(evidence, models, diagnosis_);
  return std::any_of(
      findings.begin(), findings.end(), [](const Finding& finding) {
        return finding.severity == Severity::kFatal;
      });
}

// Whether further mappings can tell something about models: the best is small
// and of use, it is as exact as the choice of cameras makes it, and there are
// two photos with which a mapping can be told to begin.
StatusOr<bool> ModelRefinement::CanMapAgain(
    const SceneEvidence& evidence,
    const std::vector<Reconstruction>& models) const {
  if (models[0].images.size() > kMostPhotosToConfirm ||
      context_.options.camera_model != "auto" || AreOfNoUse(evidence, models)) {
    return false;
  }
  FREEGS_ASSIGN_OR_RETURN(const std::vector<InitialPair> pairs,
                          BestPairs(context_.input.photos, 1, database_));
  return !pairs.empty();
}

// Does all that makes a model once more, from a later pair (see MapAgainFn).
StatusOr<std::optional<AttemptResult>> ModelRefinement::MapFromLaterPair(
    const std::string& name,
    std::optional<size_t> skip,
    CameraGroups* groups) const {
  std::vector<InitialPair> pairs;
  if (skip) {
    FREEGS_ASSIGN_OR_RETURN(
        pairs, BestPairs(context_.input.photos, *skip + 1, database_));
    if (pairs.size() <= *skip) return std::optional<AttemptResult>();
  }
  const auto map = [&]() -> StatusOr<AttemptResult> {
    MapperOptions options = options_;
    options.step = "mapping, " + name;
    options.further = true;
    const fs::path folder = store_->Folder(name) / "mapper";
    AttemptResult mapped;
    if (!skip) {
      FREEGS_ASSIGN_OR_RETURN(mapped.models,
                              MapPhotos(context_, database_, folder, options));
      return mapped;
    }
    FREEGS_ASSIGN_OR_RETURN(
        mapped.models,
        MapFromLastPair(context_, database_, folder, pairs, options));
    if (!mapped.models.empty() || options.relaxed) return mapped;
    options.relaxed = true;  // Later pairs are weaker.
    FREEGS_ASSIGN_OR_RETURN(
        mapped.models,
        MapFromLastPair(context_, database_, folder, pairs, options));
    return mapped;
  };
  FREEGS_ASSIGN_OR_RETURN(AttemptResult made, store_->Try(name, map));
  FREEGS_ASSIGN_OR_RETURN(SeparatedParts parts,
                          SeparateParts(context_,
                                        database_,
                                        made.models,
                                        store_,
                                        skip.value_or(0),
                                        ", " + name));
  if (!parts.models.empty()) made.models = std::move(parts.models);
  made.repairs = std::move(parts.attempts);
  if (!made.models.empty()) {
    NoteCameraGroups(made.models[0], groups);
    FREEGS_RETURN_IF_ERROR(ChooseCameras(nullptr, &made.models[0]).status());
  }
  return std::optional(std::move(made));
}

// Puts models that further mappings confirm in the place of those that are
// there, and says what was found out.
Status ModelRefinement::TakeConfirmed(ConfirmedPoses confirmed,
                                      const CameraGroups& groups,
                                      SceneEvidence* evidence,
                                      CameraChoice* cameras,
                                      RefinedModels* refined) const {
  if (!confirmed.models.empty()) {
    FREEGS_ASSIGN_OR_RETURN(CameraChoice their_cameras,
                            ChooseCameras(&groups, &confirmed.models[0]));
    if (!AreOfNoUse(*evidence, confirmed.models)) {
      refined->models = std::move(confirmed.models);
      if (their_cameras.problem.empty()) {
        *cameras = std::move(their_cameras);
      } else {
        // What the first choice tells is true of the first model alone.
        if (confirmed.replaced) *cameras = {};
        if (cameras->problem.empty()) {
          refined->warnings.push_back(
              "the cameras could not be chosen once more, and stay as they "
              "were before: " +
              their_cameras.problem);
        }
      }
    } else {
      // A model with uncertain photos is better than none.
      if (confirmed.replaced) {
        confirmed.replaced = false;
        confirmed.witnessed = false;
        confirmed.uncertain =
            ComparePlaces(refined->models[0], confirmed.models[0]).elsewhere;
      }
      for (Attempt& attempt : confirmed.attempts) {
        if (attempt.kept) attempt.problem = "its poses cannot be trusted";
        attempt.kept = false;
      }
    }
  }
  if (confirmed.replaced) {
    refined->warnings.push_back(
        "mapping from other photos put some elsewhere; the model is taken of "
        "whose photos most are where other models have them");
    std::erase_if(evidence->unplaced, [&](const std::string& name) {
      const std::vector<PosedImage>& images = refined->models[0].images;
      return std::any_of(images.begin(), images.end(), [&](const auto& image) {
        return image.name == name;
      });
    });
  }
  if (!confirmed.attempts.empty() && !confirmed.witnessed) {
    refined->warnings.push_back(
        "mapping from other photos did not lead to the same poses; look at the "
        "cameras before you trust them");
  }
  evidence->uncertain = std::move(confirmed.uncertain);
  refined->attempts = std::move(confirmed.attempts);
  return {};
}

StatusOr<RefinedModels> ModelRefinement::Run(std::vector<Reconstruction> models,
                                             SceneEvidence* evidence) const {
  RefinedModels refined;
  refined.models = std::move(models);
  if (refined.models.empty()) return refined;
  CameraGroups groups;
  NoteCameraGroups(refined.models[0], &groups);
  FREEGS_ASSIGN_OR_RETURN(CameraChoice cameras,
                          ChooseCameras(nullptr, &refined.models[0]));
  FREEGS_ASSIGN_OR_RETURN(const bool can,
                          CanMapAgain(*evidence, refined.models));
  if (can) {
    const size_t half = (context_.input.photos.size() + 1) / 2;
    FREEGS_ASSIGN_OR_RETURN(
        ConfirmedPoses confirmed,
        ConfirmPoses(refined.models,
                     half,
                     [&](const std::string& name, std::optional<size_t> skip) {
                       return MapFromLaterPair(name, skip, &groups);
                     }));
    FREEGS_RETURN_IF_ERROR(TakeConfirmed(
        std::move(confirmed), groups, evidence, &cameras, &refined));
  }
  if (!cameras.problem.empty()) {
    refined.warnings.push_back("COLMAP's RADIAL cameras are kept: " +
                               cameras.problem);
  }
  refined.camera_models = std::move(cameras.candidates);
  return refined;
}

}  // namespace freegs::sfm
