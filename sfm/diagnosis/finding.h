// SPDX-License-Identifier: BSD-3-Clause
// What a diagnosis may find out about the photos, and from which limits on.

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
  kLookAlikes,  // Repeated structure: see view_graph.h.
};
std::string_view FindingName(FindingKind kind);  // "too_few_photos" ...

enum class Severity {
  kNote,       // Worth knowing; explains what else went wrong.
  kDegrading,  // The result lacks something.
  kFatal,      // There is no usable result, whatever the mapper made.
};
std::string_view SeverityName(Severity severity);  // "note" ...

struct Finding {
  FindingKind kind = FindingKind::kTooFewPhotos;
  Severity severity = Severity::kNote;

  // Trying other ways to match and map the same photos cannot help.
  bool hopeless = false;

  // The numbers behind it.
  std::vector<std::pair<std::string, double>> evidence;

  std::string message;  // What was seen, a sentence without its full stop.
  std::string advice;   // What to do about it, likewise.
  std::vector<std::string> photos;  // Those it is about; empty for all.
};

struct DiagnosisOptions {
  // Fewer features in a photo are too few to match it.
  int64_t few_features = 250;

  // A photo is blurred when its sharpness is below this share of the upper
  // quartile of all photos.
  double blurred_share = 0.1;

  // All photos are blurred when the median feature is larger than this share
  // of the longest side.
  double blurred_scale = 0.008;

  // Fewer photos leave most of a scene unseen.
  int few_photos = 8;

  // Share of registered photos above which a result is good.
  double good_share = 0.9;
};

// Names for a message, cut after a few: "a.jpg, b.jpg and 7 more".
std::string SomeNames(const std::vector<std::string>& names);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_DIAGNOSIS_FINDING_H_
