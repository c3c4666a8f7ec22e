// SPDX-License-Identifier: BSD-3-Clause
// What the rules of the diagnosis look at. Only the files of this folder
// include this header.

#ifndef FREEGS_SFM_DIAGNOSIS_DIAGNOSIS_SCENE_H_
#define FREEGS_SFM_DIAGNOSIS_DIAGNOSIS_SCENE_H_

#include <cstddef>
#include <string>
#include <vector>

#include "sfm/diagnosis/evidence.h"
#include "sfm/diagnosis/finding.h"

namespace freegs::sfm {

// A photo is blurred when its sharpness is below this share of
// SharpnessOfSharp.
inline constexpr double kBlurredShare = 0.1;

// Upper quartile of the sharpness of all photos for which it is known; 0 if it
// is known for none.
double SharpnessOfSharp(const SceneEvidence& evidence);

// The evidence and models of a scene, with what several rules derive from them.
// It refers to its arguments, which must outlive it.
struct DiagnosedScene {
  const SceneEvidence& evidence;
  const std::vector<Reconstruction>& models;
  const DiagnosisOptions& options;
  PhotoGroups groups;
  TurningOnTheSpot turning;
  size_t registered = 0;  // Photos with a pose in models[0].
  double sharp = 0;       // SharpnessOfSharp(evidence).

  DiagnosedScene(const SceneEvidence& scene,
                 const std::vector<Reconstruction>& made,
                 const DiagnosisOptions& how);

  size_t count() const { return evidence.photos.size(); }
  // Enough photos have a pose for the result to count as good.
  bool good() const {
    return static_cast<double>(registered) >=
           kGoodShare * static_cast<double>(count());
  }
  // A photo of the main group that is not blurred has no pose in models[0].
  bool LinkedPhotosMissing() const;
  // models[0] has nearly all photos, wide angles between rays and many points
  // in each photo, and the homographies show the parallax that it claims. That
  // proves that the camera moved, even if homographies explain most pairs
  // because neighbouring photos are nearly the same.
  bool HasDepth() const;
  // The photo is much less sharp than the sharpest quarter of all photos.
  bool IsBlurred(const PhotoEvidence& photo) const {
    return photo.sharpness > 0 && photo.sharpness < kBlurredShare * sharp;
  }
  bool HasFewFeatures(const PhotoEvidence& photo) const {
    return photo.num_features < options.few_features;
  }
  // The names of photos, given their places in evidence.photos.
  std::vector<std::string> Names(const std::vector<size_t>& photos) const;
};

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_DIAGNOSIS_DIAGNOSIS_SCENE_H_
