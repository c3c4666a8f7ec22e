// SPDX-License-Identifier: BSD-3-Clause
// What the rules of diagnosis look at. For diagnosis*.cc only.

#ifndef FREEGS_SFM_DIAGNOSIS_DIAGNOSIS_SCENE_H_
#define FREEGS_SFM_DIAGNOSIS_DIAGNOSIS_SCENE_H_

#include <cstddef>
#include <string>
#include <vector>

#include "sfm/diagnosis/evidence.h"
#include "sfm/diagnosis/finding.h"

namespace freegs::sfm {

// Upper quartile of the photos' sharpness, where known.
double SharpnessOfSharp(const SceneEvidence& evidence);

// What all rules look at.
struct DiagnosedScene {
  const SceneEvidence& evidence;
  const std::vector<Reconstruction>& models;
  const DiagnosisOptions& options;
  PhotoGroups groups;
  TurningOnTheSpot turning;
  size_t registered = 0;
  double sharp = 0;  // Upper quartile of sharpness.

  DiagnosedScene(const SceneEvidence& scene,
                 const std::vector<Reconstruction>& made,
                 const DiagnosisOptions& how);

  size_t count() const { return evidence.photos.size(); }
  bool good() const {
    return static_cast<double>(registered) >=
           options.good_share * static_cast<double>(count());
  }
  // A photo of the main group is not in the model.
  bool LinkedPhotosMissing() const;
  // A model of nearly all photos with wide angles and many points in each
  // proves that the camera moved, however alike neighbouring photos are.
  bool HasDepth() const;
  // Much less sharp than the others.
  bool IsBlurred(const PhotoEvidence& photo) const {
    return photo.sharpness > 0 &&
           photo.sharpness < options.blurred_share * sharp;
  }
  bool HasFewFeatures(const PhotoEvidence& photo) const {
    return photo.num_features < options.few_features;
  }
  std::vector<std::string> Names(const std::vector<size_t>& photos) const;
};

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_DIAGNOSIS_DIAGNOSIS_SCENE_H_
