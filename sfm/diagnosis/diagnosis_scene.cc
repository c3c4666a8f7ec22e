// SPDX-License-Identifier: BSD-3-Clause
// Derives from the evidence what several rules need.

#include "sfm/diagnosis/diagnosis_scene.h"

#include <algorithm>
#include <utility>

#include "core/quantile.h"
#include "sfm/scene/reconstruction_measures.h"

namespace freegs::sfm {
namespace {

// A model has depth only if ShownParallax is this or more.
constexpr double kMinParallax = 0.35;

}  // namespace

double SharpnessOfSharp(const SceneEvidence& evidence) {
  std::vector<double> values;
  for (const PhotoEvidence& photo : evidence.photos) {
    if (photo.sharpness > 0) values.push_back(photo.sharpness);
  }
  return NearestQuantile(std::move(values), 0.75);
}

DiagnosedScene::DiagnosedScene(const SceneEvidence& scene,
                               const std::vector<Reconstruction>& made,
                               const DiagnosisOptions& how)
    : evidence(scene),
      models(made),
      options(how),
      groups(GroupByMatches(scene, made)),
      turning(MeasureTurning(scene)) {
  registered = static_cast<size_t>(
      std::count(groups.registered.begin(), groups.registered.end(), true));
  sharp = SharpnessOfSharp(scene);
}

bool DiagnosedScene::LinkedPhotosMissing() const {
  for (size_t i = 0; i < count(); ++i) {
    if (groups.group[i] == 0 && !groups.registered[i] &&
        !IsBlurred(evidence.photos[i])) {
      return true;
    }
  }
  return false;
}

bool DiagnosedScene::HasDepth() const {
  if (!good() || models.empty()) return false;
  const ReconstructionMeasures measures = MeasureReconstruction(models[0]);
  return measures.median_triangulation_deg >= 3 &&
         measures.mean_reprojection_error_px <= 2 &&
         measures.observations >= 100 * registered &&
         ShownParallax(evidence, models[0], turning.focal) >= kMinParallax;
}

std::vector<std::string> DiagnosedScene::Names(
    const std::vector<size_t>& photos) const {
  std::vector<std::string> names;
  for (const size_t i : photos) names.push_back(evidence.photos[i].name);
  return names;
}

}  // namespace freegs::sfm
