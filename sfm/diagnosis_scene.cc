// SPDX-License-Identifier: BSD-3-Clause
// What the rules of diagnosis look at, and what is known of single photos.

#include "sfm/diagnosis_scene.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "sfm/health.h"

namespace freegs::sfm {

double Quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  const auto at =
      values.begin() +
      static_cast<ptrdiff_t>(std::floor(share * (values.size() - 1) + 0.5));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

std::string ShortText(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.3g", value);
  return text;
}

double SharpnessOfSharp(const SceneEvidence& evidence) {
  std::vector<double> values;
  for (const PhotoEvidence& photo : evidence.photos) {
    if (photo.sharpness > 0) values.push_back(photo.sharpness);
  }
  return Quantile(std::move(values), 0.75);
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
  const Health health = MeasureHealth({models[0]}, {}, true, {});
  return health.median_triangulation_deg >= 3 &&
         health.mean_reprojection_error_px <= 2 &&
         health.observations >= 100 * registered;
}

std::vector<std::string> DiagnosedScene::Names(
    const std::vector<size_t>& photos) const {
  std::vector<std::string> names;
  for (const size_t i : photos) names.push_back(evidence.photos[i].name);
  return names;
}

std::vector<bool> FindBlurredPhotos(const SceneEvidence& evidence,
                                    const DiagnosisOptions& options) {
  const double limit = options.blurred_share * SharpnessOfSharp(evidence);
  std::vector<bool> blurred;
  for (const PhotoEvidence& photo : evidence.photos) {
    blurred.push_back(photo.sharpness > 0 && photo.sharpness < limit);
  }
  return blurred;
}

std::map<std::string, std::string> ExplainUnregistered(
    const SceneEvidence& evidence,
    const std::vector<Reconstruction>& models,
    const DiagnosisOptions& options) {
  const DiagnosedScene scene(evidence, models, options);
  std::vector<int64_t> partners(scene.count(), 0);
  std::vector<int64_t> matches(scene.count(), 0);
  for (const PairEvidence& pair : evidence.pairs) {
    for (const size_t i : {pair.first, pair.second}) {
      ++partners[i];
      matches[i] += pair.num_matches;
    }
  }
  std::map<std::string, std::string> reasons;
  for (size_t i = 0; i < scene.count(); ++i) {
    if (scene.groups.registered[i]) continue;
    const PhotoEvidence& photo = evidence.photos[i];
    std::string& reason = reasons[photo.name];
    if (!photo.readable) {
      reason = "COLMAP could not read it";
      continue;
    }
    reason = std::to_string(photo.num_features) + " features; ";
    if (scene.IsBlurred(photo)) {
      reason += "blurred (sharpness " + ShortText(photo.sharpness) +
                ", the others' " + ShortText(scene.sharp) + "); ";
    }
    if (partners[i] == 0) {
      reason += "matches no other photo";
      continue;
    }
    reason += "matches " + std::to_string(partners[i]) + " photos with " +
              std::to_string(matches[i]) + " features in all";
    const auto& members = scene.groups.members[scene.groups.group[i]];
    if (scene.groups.group[i] > 0) {
      reason += ", none of them well in the main model";
      if (members.size() >= kMinGroup) {
        reason += "; one of " + std::to_string(members.size()) +
                  " photos apart from the others, perhaps another scene";
      }
    }
    for (size_t k = 1; k < models.size(); ++k) {
      const auto& images = models[k].images;
      if (std::any_of(images.begin(), images.end(), [&](const auto& image) {
            return image.name == photo.name;
          })) {
        reason += "; part of the separate model sparse/" + std::to_string(k);
        break;
      }
    }
  }
  return reasons;
}

}  // namespace freegs::sfm
