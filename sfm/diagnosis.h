// SPDX-License-Identifier: BSD-3-Clause
// Why structure from motion failed, or how far its result can be trusted, in
// words that tell what to do about it.

#ifndef FREEGS_SFM_DIAGNOSIS_H_
#define FREEGS_SFM_DIAGNOSIS_H_

#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sfm/evidence.h"
#include "sfm/reconstruction.h"

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

// The findings, worst first. models: what was reconstructed, the best first.
std::vector<Finding> Diagnose(const SceneEvidence& evidence,
                              const std::vector<Reconstruction>& models,
                              const DiagnosisOptions& options);

// For each photo whether it is much more blurred than the others. Such photos
// are not worth another attempt.
std::vector<bool> FindBlurredPhotos(const SceneEvidence& evidence,
                                    const DiagnosisOptions& options);

// For each photo that the best model lacks: why, as far as is known.
std::map<std::string, std::string> ExplainUnregistered(
    const SceneEvidence& evidence,
    const std::vector<Reconstruction>& models,
    const DiagnosisOptions& options);

// Names for a message, cut after a few: "a.jpg, b.jpg and 7 more".
std::string SomeNames(const std::vector<std::string>& names);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_DIAGNOSIS_H_
