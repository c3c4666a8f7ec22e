// SPDX-License-Identifier: BSD-3-Clause
// Names of findings.

#include "sfm/diagnosis/finding.h"

namespace freegs::sfm {

std::string_view FindingName(FindingKind kind) {
  switch (kind) {
    case FindingKind::kTooFewPhotos:
      return "too_few_photos";
    case FindingKind::kTooLittleTexture:
      return "too_little_texture";
    case FindingKind::kBlurred:
      return "blurred";
    case FindingKind::kNoBaseline:
      return "no_baseline";
    case FindingKind::kSeparateScenes:
      return "separate_scenes";
    case FindingKind::kNoOverlap:
      return "no_overlap";
    case FindingKind::kPlanarScene:
      return "planar_scene";
    case FindingKind::kLookAlikes:
      return "look_alikes";
    case FindingKind::kUncertainPoses:
      return "uncertain_poses";
    case FindingKind::kUnfitPoses:
      return "unfit_poses";
  }
  return "";
}

std::string_view SeverityName(Severity severity) {
  switch (severity) {
    case Severity::kDegrading:
      return "degrading";
    case Severity::kFatal:
      return "fatal";
  }
  return "";
}

}  // namespace freegs::sfm
