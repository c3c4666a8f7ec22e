// SPDX-License-Identifier: BSD-3-Clause
// Reasons, photo by photo.

#include "sfm/diagnosis/photo_reasons.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "core/number_text.h"
#include "sfm/diagnosis/diagnosis_scene.h"

namespace freegs::sfm {

std::vector<bool> FindBlurredPhotos(const SceneEvidence& evidence) {
  const double limit = kBlurredShare * SharpnessOfSharp(evidence);
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
    reason = std::to_string(photo.num_features) + " features; ";
    if (scene.IsBlurred(photo)) {
      reason += "blurred (sharpness " + FormatSignificant(photo.sharpness, 3) +
                ", the others' " + FormatSignificant(scene.sharp, 3) + "); ";
    }
    if (partners[i] == 0) {
      reason += "matches no other photo";
      continue;
    }
    reason += "matches " + std::to_string(partners[i]) + " photos with " +
              std::to_string(matches[i]) + " features in all";
    if (std::binary_search(
            evidence.uncertain.begin(), evidence.uncertain.end(), photo.name)) {
      reason +=
          "; left out because its place depends on where the mapping begins";
      continue;
    }
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
