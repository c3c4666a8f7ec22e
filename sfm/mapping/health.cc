// SPDX-License-Identifier: BSD-3-Clause
// Measures and judges a reconstruction.

#include "sfm/mapping/health.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "core/number_text.h"
#include "core/text.h"
#include "sfm/colmap/sfm_options.h"

namespace freegs::sfm {
namespace {

double Rounded(double value) { return std::round(value * 1e6) / 1e6; }

std::string Fixed(double value) { return FormatFixed(value, 2); }

constexpr char kMoreOverlap[] =
    "take more photos with at least two thirds overlap from neighbouring "
    "positions, sharp and of a textured scene";

constexpr char kPerImage[] = "per_image";

// With fewer registered photos a result is failed, whatever their share.
constexpr int kMinRegistered = 3;

// Below this median triangulation angle it is failed: depth would be guesswork.
constexpr double kMinTriangulationDeg = 1.0;

// Above this mean reprojection error it is degraded.
constexpr double kGoodReprojectionErrorPx = 2.0;

// Above this share of observations whose points lie behind the camera it is
// degraded. COLMAP's own models have none.
constexpr double kMaxBehindShare = 0.1;

// The advice where points lie behind the cameras.
constexpr char kCheckAxes[] =
    "check the camera axes of the poses: x points right, y down and z forward "
    "in a COLMAP model, and x right, y up and z backward in a transforms.json";

// The advice where poses come from elsewhere.
constexpr char kMorePoses[] =
    "give poses for the other photos, or leave these photos out; or let "
    "structure from motion find all poses (without sfm.import)";

// So many findings, the worst ones, are told in the reason and the advice.
constexpr size_t kFindingsTold = 2;

// The reason, followed by what the findings say.
std::string Reasons(const Health& health, std::string reason) {
  size_t told = 0;
  for (const Finding& finding : health.findings) {
    if (told++ == kFindingsTold) break;
    reason += (reason.empty() ? "" : "; ") + finding.message;
  }
  return reason;
}

// The advice of the findings, or the other one if there are none.
std::string Advice(const Health& health, const std::string& otherwise) {
  std::string advice;
  size_t told = 0;
  for (const Finding& finding : health.findings) {
    if (told++ == kFindingsTold) break;
    // Findings of one kind share their advice.
    if (advice.find(finding.advice) != std::string::npos) continue;
    advice += (advice.empty() ? "" : "; ") + finding.advice;
  }
  return advice.empty() ? otherwise : advice;
}

bool HasFinding(const Health& health, Severity least) {
  return std::any_of(
      health.findings.begin(),
      health.findings.end(),
      [least](const Finding& finding) { return finding.severity >= least; });
}

// What is wrong with a result, and what to do about it. Both are empty if
// nothing is wrong.
struct Judgement {
  std::string reason;
  std::string advice;
};

// What makes more photos have a pose.
std::string MoreOverlap(const MappingFacts& facts) {
  if (facts.imported) return kMorePoses;
  std::vector<std::string> tries;
  if (facts.max_features < SfmOptions::kManyFeatures) {
    tries.emplace_back("--sfm.max_features 8192");
  }
  if (!facts.all_pairs_compared) tries.emplace_back("--sfm.matcher exhaustive");
  if (facts.camera != kPerImage) {
    tries.emplace_back("--sfm.camera per_image");
  }
  return kMoreOverlap + (tries.empty() ? "" : "; or try " + Joined(tries));
}

// What helps where the lens was not described well.
std::string OtherLens(const MappingFacts& facts) {
  std::string advice = "the lens may need another model: try ";
  if (facts.camera_model == "OPENCV") {
    advice += "--sfm.camera_model OPENCV_FISHEYE if it is very wide";
  } else if (facts.camera_model == "OPENCV_FISHEYE") {
    advice += "--sfm.camera_model OPENCV if it is not very wide";
  } else {
    advice += "--sfm.camera_model OPENCV (OPENCV_FISHEYE for very wide lenses)";
  }
  if (facts.camera != kPerImage) {
    advice += ", or --sfm.camera per_image if the zoom changed between photos";
  }
  return advice;
}

// Why the result cannot be used.
Judgement FailureOf(const Health& health,
                    const HealthOptions& options,
                    const MappingFacts& facts,
                    bool triangulated) {
  const std::string registered = std::to_string(health.registered) + " of " +
                                 std::to_string(health.images) +
                                 " photos got a camera pose";
  if (health.registered < kMinRegistered) {
    return {Reasons(health,
                    registered + ", at least " +
                        std::to_string(kMinRegistered) + " are needed"),
            Advice(health, MoreOverlap(facts))};
  }
  if (HasFinding(health, Severity::kFatal)) {
    return {Reasons(health, ""), Advice(health, MoreOverlap(facts))};
  }
  if (health.registered_share() < options.min_registered_share) {
    std::string advice = MoreOverlap(facts);
    if (health.model_sizes.size() > 1) {
      advice +=
          "; the photos fell into separate models, so add photos that connect "
          "them";
    }
    return {Reasons(health,
                    registered + ", less than the share of " +
                        Fixed(options.min_registered_share) +
                        " (sfm.min_registered_share)"),
            Advice(health, advice)};
  }
  if (triangulated && health.measures.num_points == 0) {
    return {Reasons(health, "no points were triangulated"),
            Advice(health, MoreOverlap(facts))};
  }
  if (triangulated && health.measures.observations == 0 &&
      health.measures.behind > 0) {
    return {"all points lie behind the cameras", kCheckAxes};
  }
  if (triangulated &&
      health.measures.median_triangulation_deg < kMinTriangulationDeg) {
    return {"the median triangulation angle is " +
                Fixed(health.measures.median_triangulation_deg) +
                " degrees: the camera hardly moved, or only turned",
            "walk around the scene instead of turning on the spot, so that "
            "each part is seen from well apart positions"};
  }
  return {};
}

// What a usable result lacks.
Judgement FlawOf(const Health& health,
                 const MappingFacts& facts,
                 bool triangulated) {
  if (health.registered_share() < kGoodShare) {
    return {Reasons(health,
                    std::to_string(health.registered) + " of " +
                        std::to_string(health.images) +
                        " photos got a camera pose"),
            Advice(health,
                   "the others are left out; for better coverage, " +
                       MoreOverlap(facts))};
  }
  const auto behind = static_cast<double>(health.measures.behind);
  const double all = behind + static_cast<double>(health.measures.observations);
  if (triangulated && behind > kMaxBehindShare * all) {
    return {"a share of " + Fixed(behind / all) +
                " of the observations is of points behind the cameras",
            kCheckAxes};
  }
  if (triangulated &&
      health.measures.mean_reprojection_error_px > kGoodReprojectionErrorPx) {
    const std::string error =
        "the mean reprojection error is " +
        Fixed(health.measures.mean_reprojection_error_px) + " px";
    if (facts.imported) {
      return {error + ": the imported poses do not fit their own points",
              "let structure from motion find the poses (without sfm.import)"};
    }
    return {error, OtherLens(facts)};
  }
  if (HasFinding(health, Severity::kDegrading)) {
    return {Reasons(health, ""), Advice(health, "")};
  }
  return {};
}

void Judge(const HealthOptions& options,
           const MappingFacts& facts,
           bool triangulated,
           Health* health) {
  Judgement judgement = FailureOf(*health, options, facts, triangulated);
  health->verdict = Verdict::kFailed;
  if (judgement.reason.empty()) {
    judgement = FlawOf(*health, facts, triangulated);
    health->verdict =
        judgement.reason.empty() ? Verdict::kOk : Verdict::kDegraded;
  }
  health->reason = std::move(judgement.reason);
  health->advice = std::move(judgement.advice);
}

nlohmann::json FindingsToJson(const std::vector<Finding>& findings) {
  nlohmann::json list = nlohmann::json::array();
  for (const Finding& finding : findings) {
    nlohmann::json evidence = nlohmann::json::object();
    for (const auto& [name, value] : finding.evidence) {
      evidence[name] = Rounded(value);
    }
    list.push_back({{"kind", FindingName(finding.kind)},
                    {"severity", SeverityName(finding.severity)},
                    {"evidence", evidence},
                    {"message", finding.message},
                    {"advice", finding.advice},
                    {"photos", finding.photos}});
  }
  return list;
}

// Null where nothing was measured.
nlohmann::json ErrorToJson(double error_px, size_t measured) {
  return measured > 0 ? nlohmann::json(Rounded(error_px)) : nlohmann::json();
}

nlohmann::json AttemptsToJson(const std::vector<Attempt>& attempts) {
  nlohmann::json list = nlohmann::json::array();
  for (const Attempt& attempt : attempts) {
    list.push_back({{"name", attempt.name},
                    {"why", attempt.why},
                    {"registered", attempt.registered},
                    {"models", attempt.models},
                    {"points", attempt.points},
                    {"mean_reprojection_error_px",
                     ErrorToJson(attempt.mean_error_px, attempt.points)},
                    {"kept", attempt.kept},
                    {"problem", attempt.problem}});
  }
  return list;
}

}  // namespace

Status HealthOptions::Check() const {
  if (!(min_registered_share >= 0 && min_registered_share <= 1)) {
    return InvalidArgumentError("min_registered_share must be between 0 and 1");
  }
  return {};
}

std::string_view VerdictName(Verdict verdict) {
  switch (verdict) {
    case Verdict::kOk:
      return "ok";
    case Verdict::kDegraded:
      return "degraded";
    case Verdict::kFailed:
      return "failed";
  }
  return "failed";
}

Health MeasureHealth(const std::vector<Reconstruction>& models,
                     const std::vector<std::string>& names,
                     bool triangulated,
                     const HealthOptions& options,
                     const MappingFacts& facts,
                     std::vector<Finding> findings) {
  Health health;
  health.findings = std::move(findings);
  health.images = static_cast<int>(names.size());
  health.max_features = facts.max_features;
  std::set<std::string_view> posed;
  if (!models.empty()) {
    health.cameras = models[0].cameras;
    for (const PosedImage& image : models[0].images) posed.insert(image.name);
    health.measures = MeasureReconstruction(models[0]);
  }
  for (const std::string& name : names) {
    if (posed.contains(name)) {
      ++health.registered;
    } else {
      health.unregistered[name];
    }
  }
  for (const Reconstruction& model : models) {
    health.model_sizes.push_back(static_cast<int>(model.images.size()));
  }
  Judge(options, facts, triangulated, &health);
  return health;
}

nlohmann::json HealthToJson(const Health& health) {
  nlohmann::ordered_json cameras = nlohmann::json::array();
  for (const Camera& camera : health.cameras) {
    cameras.push_back({{"id", camera.id},
                       {"model", GetCameraModel(camera.model).name},
                       {"width", camera.width},
                       {"height", camera.height},
                       {"params", camera.params}});
  }
  nlohmann::json camera_models = nlohmann::json::array();
  for (const CameraCandidate& candidate : health.camera_models) {
    nlohmann::json row = {
        {"model", GetCameraModel(candidate.model).name},
        {"sharing", CameraSharingName(candidate.sharing)},
        {"parameters", candidate.parameters},
        {"held_out_error_px", Rounded(candidate.held_out_error_px)},
        {"held_out_median_px", Rounded(candidate.held_out_median_px)},
        {"rms_px", Rounded(candidate.rms_px)},
        {"bic", Rounded(candidate.bic)},
        {"chosen", candidate.chosen}};
    if (!candidate.refused.empty()) row["reason"] = candidate.refused;
    camera_models.push_back(std::move(row));
  }
  nlohmann::json names = nlohmann::json::array();
  nlohmann::json reasons = nlohmann::json::object();
  for (const auto& [name, reason] : health.unregistered) {
    names.push_back(name);
    if (!reason.empty()) reasons[name] = reason;
  }
  return {
      {"verdict", VerdictName(health.verdict)},
      {"reason", health.reason},
      {"advice", health.advice},
      {"images", health.images},
      {"registered", health.registered},
      {"registered_share", Rounded(health.registered_share())},
      {"models", health.model_sizes.size()},
      {"model_sizes", health.model_sizes},
      {"mean_reprojection_error_px",
       ErrorToJson(health.measures.mean_reprojection_error_px,
                   health.measures.observations)},
      {"median_track_length", health.measures.median_track_length},
      {"median_triangulation_deg",
       Rounded(health.measures.median_triangulation_deg)},
      {"num_points", health.measures.num_points},
      {"observations", health.measures.observations},
      {"findings", FindingsToJson(health.findings)},
      {"attempts", AttemptsToJson(health.attempts)},
      {"pairs", MatchedPairsToJson(health.pairs)},
      {"image_size", health.image_size},
      {"max_features", health.max_features},
      {"unregistered", names},
      {"unregistered_reasons", reasons},
      {"warnings", health.warnings},
      {"cameras", cameras},
      {"camera_models", camera_models},
      {"source", health.source},
      {"colmap_version", health.colmap_version},
  };
}

}  // namespace freegs::sfm
