// SPDX-License-Identifier: BSD-3-Clause
// Whether a reconstruction is good enough to go on with. COLMAP ends without
// an error when two of six hundred photos were registered; we do not.

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
  // Below this share of registered photos the result is not usable.
  double min_registered_share = 0.5;

  // Below this share a usable result is called degraded.
  double good_registered_share = 0.9;

  // Fewer registered photos are never usable.
  int min_registered = 3;

  // Below this median triangulation angle, in degrees, depth is guesswork.
  double min_triangulation_deg = 1.0;

  // Above this mean reprojection error, in pixels, a result is degraded.
  double good_reprojection_error_px = 2.0;

  Status Check() const;
};

enum class Verdict { kOk, kDegraded, kFailed };
std::string_view VerdictName(Verdict verdict);  // "ok", "degraded", "failed".

struct Health {
  Verdict verdict = Verdict::kFailed;
  std::string reason;  // One sentence; empty when ok.
  std::string advice;  // What to try; empty when ok.

  int images = 0;                // Photos given.
  int registered = 0;            // Photos with a pose.
  std::vector<int> model_sizes;  // Registered photos of each model made.

  // How well the points of models[0] fit its photos.
  ReconstructionMeasures measures;

  // Strongest matches between photos that the model contradicts.
  size_t contradictions = 0;

  // What was found out about the photos, worst first, and what was tried.
  std::vector<Finding> findings;
  std::vector<Attempt> attempts;

  // Which pairs of photos were matched.
  MatchedPairs pairs;
  int image_size = 0;  // Of the images that features were taken from; 0: none.

  // Photos without a pose, and why if known.
  std::map<std::string, std::string> unregistered;
  std::vector<std::string> warnings;
  std::vector<Camera> cameras;
  std::vector<CameraCandidate> camera_models;  // Those tried, if any.
  std::string source;                          // "colmap", "import" ...
  std::string colmap_version;                  // Empty when COLMAP was not run.

  double registered_share() const {
    return images > 0 ? static_cast<double>(registered) / images : 0;
  }
};

// Measures models[0], the best one, and judges it; the others only count.
// names: all photos given. triangulated: whether its points come from matches;
// if not, only the registered share is judged. findings: of Diagnose(); a fatal
// one makes any result failed, a degrading one no better than degraded.
Health MeasureHealth(const std::vector<Reconstruction>& models,
                     const std::vector<std::string>& names,
                     bool triangulated,
                     const HealthOptions& options,
                     size_t contradictions = 0,
                     std::vector<Finding> findings = {});

// health.json.
nlohmann::json HealthToJson(const Health& health);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_MAPPING_HEALTH_H_
