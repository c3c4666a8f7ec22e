// SPDX-License-Identifier: BSD-3-Clause
// Judges whether a reconstruction is good enough to go on with. COLMAP ends
// without an error even if it registered two of six hundred photos; the verdict
// here tells such a result from a good one.

#ifndef FREEGS_SFM_MAPPING_HEALTH_H_
#define FREEGS_SFM_MAPPING_HEALTH_H_

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/status.h"
#include "sfm/calibration/camera_selection.h"
#include "sfm/diagnosis/finding.h"
#include "sfm/mapping/attempt.h"
#include "sfm/matching/pair_selection.h"
#include "sfm/scene/reconstruction.h"
#include "sfm/scene/reconstruction_measures.h"

namespace freegs::sfm {

struct HealthOptions {
  // Below this share of registered photos the verdict is failed.
  double min_registered_share = 0.5;

  // kInvalidArgument unless the share lies in 0..1.
  Status Check() const;
};

// How a reconstruction was made, as far as the advice depends on it.
struct MappingFacts {
  // Whether the poses were found elsewhere: then what is tried with COLMAP's
  // options is no advice.
  bool imported = false;

  // So many features of each photo were kept at most.
  int max_features = 0;

  // Whether every two photos were compared: then that is no advice.
  bool all_pairs_compared = false;

  // SfmOptions::camera and camera_model: what is in force is no advice.
  std::string camera = "auto";
  std::string camera_model = "auto";
};

enum class Verdict { kOk, kDegraded, kFailed };
std::string_view VerdictName(Verdict verdict);  // "ok", "degraded", "failed".

struct Health {
  Verdict verdict = Verdict::kFailed;
  std::string reason;  // One sentence; empty when ok.
  std::string advice;  // What the user can try; empty when ok.

  int images = 0;                // Photos given.
  int registered = 0;            // Photos with a pose.
  std::vector<int> model_sizes;  // Registered photos of each model made.

  // How well the points of models[0] fit its photos.
  ReconstructionMeasures measures;

  // What was found out about the photos, the worst first.
  std::vector<Finding> findings;

  // What was tried, in order.
  std::vector<Attempt> attempts;

  // The pairs of photos that were matched, the longest side, in pixels, of the
  // images that features were taken from, and how many of each photo were kept
  // at most. Empty and 0 without COLMAP.
  MatchedPairs pairs;
  int image_size = 0;
  int max_features = 0;

  // The names of the photos without a pose, each with the reason, or with an
  // empty string if none is known.
  std::map<std::string, std::string> unregistered;
  std::vector<std::string> warnings;
  std::vector<Camera> cameras;  // Those of models[0].

  // The cameras among which one was chosen; empty if there was no choice.
  std::vector<CameraCandidate> camera_models;
  std::string source;          // "colmap", "import" ...
  std::string colmap_version;  // Empty if COLMAP was not run.

  double registered_share() const {
    return images > 0 ? static_cast<double>(registered) / images : 0;
  }
};

// Measures models[0], which must be the best model, and judges it. Of the other
// models only the sizes are noted.
//
// names: all photos given. triangulated: whether the points come from matches;
// if not (imported poses with random points), errors and angles are not judged.
// findings: those of Diagnose(); a fatal one makes the verdict failed, a
// degrading one makes it no better than degraded. The caller fills in attempts
// and all that follows them in Health, except max_features, unregistered and
// cameras.
//
//   Health health = MeasureHealth(
//       result.models, names, true, options, facts, result.findings);
//   if (health.verdict == Verdict::kFailed) Show(health.reason, health.advice);
Health MeasureHealth(const std::vector<Reconstruction>& models,
                     const std::vector<std::string>& names,
                     bool triangulated,
                     const HealthOptions& options,
                     const MappingFacts& facts = {},
                     std::vector<Finding> findings = {});

// The content of health.json.
nlohmann::json HealthToJson(const Health& health);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_MAPPING_HEALTH_H_
