// SPDX-License-Identifier: BSD-3-Clause
// What a diagnosis can find out about the photos, and the limits of its rules.

#ifndef FREEGS_SFM_DIAGNOSIS_FINDING_H_
#define FREEGS_SFM_DIAGNOSIS_FINDING_H_

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace freegs::sfm {

enum class FindingKind {
  kTooFewPhotos,
  kTooLittleTexture,
  kBlurred,
  kNoBaseline,      // The camera only turned.
  kSeparateScenes,  // Groups of photos without links between them.
  kNoOverlap,       // Photos without links to any other.
  kPlanarScene,
  kLookAlikes,      // Repeated structure: see view_groups.h.
  kUncertainPoses,  // Mappings disagree: see confirm_poses.h.
  kUnfitPoses,      // Imported poses contradict the photos: see known_poses.h.
};
std::string_view FindingName(FindingKind kind);  // "too_few_photos" ...

enum class Severity {
  kDegrading,  // The verdict is no better than degraded.
  kFatal,      // The verdict is failed, whatever the mapper made.
};
std::string_view SeverityName(Severity severity);  // "degrading" or "fatal".

struct Finding {
  FindingKind kind = FindingKind::kTooFewPhotos;
  Severity severity = Severity::kDegrading;

  // True if no other way of matching and mapping these photos can help.
  bool hopeless = false;

  // The measured values that led to it, with their names, and the limits.
  std::vector<std::pair<std::string, double>> evidence;

  std::string message;  // What was seen; a sentence without its full stop.
  std::string advice;   // What the user can do about it, likewise.
  std::vector<std::string> photos;  // Names; empty if it is about all photos.
};

// A result in which at least this share of the photos has a pose is good. This
// limit and the others were chosen on the photo sets of docs/sfm.md.
inline constexpr double kGoodShare = 0.9;

struct DiagnosisOptions {
  // A photo with fewer features than these cannot be matched reliably.
  int64_t few_features = 250;
};

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_DIAGNOSIS_FINDING_H_
