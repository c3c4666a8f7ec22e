// SPDX-License-Identifier: BSD-3-Clause
// Findings from evidence.

#include "sfm/diagnosis/diagnosis.h"

#include <algorithm>
#include <cmath>

#include "core/number_text.h"
#include "core/quantile.h"
#include "core/text.h"
#include "sfm/diagnosis/diagnosis_scene.h"

namespace freegs::sfm {
namespace {

// Points that a photo of a model must see on average. Models of blurred or bare
// scenes have some 60 of mostly wrong ones, sound ones hundreds.
constexpr double kFewObservations = 80;

// Fewer photos than these leave most of a scene unseen.
constexpr int kFewPhotos = 8;

// All photos count as blurred when the median size of their features exceeds
// this share of a photo's longest side.
constexpr double kBlurredScale = 0.008;

void FindTooFewPhotos(const DiagnosedScene& scene,
                      std::vector<Finding>* findings) {
  const int count = static_cast<int>(scene.count());
  if (count >= kFewPhotos) return;
  Finding finding;
  finding.kind = FindingKind::kTooFewPhotos;
  finding.severity = count < 3 ? Severity::kFatal : Severity::kDegrading;
  finding.hopeless = count < 3;
  finding.evidence = {{"photos", count}};
  finding.message = count == 1
                        ? "there is only one photo"
                        : "there are only " + std::to_string(count) + " photos";
  finding.advice =
      "take at least 20 photos from all around the scene, each showing two "
      "thirds of what the one before it shows";
  findings->push_back(std::move(finding));
}

void FindBlur(const DiagnosedScene& scene, std::vector<Finding>* findings) {
  std::vector<double> scales;
  std::vector<size_t> blurred;
  for (size_t i = 0; i < scene.count(); ++i) {
    const PhotoEvidence& photo = scene.evidence.photos[i];
    if (photo.feature_scale > 0) scales.push_back(photo.feature_scale);
    if (scene.IsBlurred(photo) && !scene.groups.registered[i]) {
      blurred.push_back(i);
    }
  }
  Finding finding;
  finding.kind = FindingKind::kBlurred;
  finding.advice =
      "take them again with a steady hand, focused and with more light";
  const double scale = UpperMedian(scales);
  if (scale > kBlurredScale) {
    finding.severity = Severity::kDegrading;
    finding.evidence = {{"median_feature_scale", scale},
                        {"limit", kBlurredScale},
                        {"sharpness", scene.sharp}};
    finding.message =
        "the photos are blurred: half of what stands out in them is wider "
        "than " +
        FormatSignificant(100 * scale, 3) + " % of the photo";
    findings->push_back(std::move(finding));
    return;
  }
  if (blurred.empty()) return;
  double worst = 0;
  for (const size_t i : blurred) {
    worst = std::max(worst, scene.evidence.photos[i].sharpness);
  }
  finding.severity = Severity::kDegrading;
  finding.photos = scene.Names(blurred);
  finding.evidence = {{"photos", static_cast<double>(blurred.size())},
                      {"sharpness_at_most", worst},
                      {"sharpness_of_sharp_photos", scene.sharp}};
  finding.message = SomeNames(finding.photos) +
                    (blurred.size() == 1 ? " is" : " are") +
                    " much more blurred than the others (sharpness at most " +
                    FormatSignificant(worst, 3) + ", theirs " +
                    FormatSignificant(scene.sharp, 3) + ")";
  findings->push_back(std::move(finding));
}

void FindLittleTexture(const DiagnosedScene& scene,
                       std::vector<Finding>* findings) {
  std::vector<double> counts;
  std::vector<size_t> weak;
  for (size_t i = 0; i < scene.count(); ++i) {
    const PhotoEvidence& photo = scene.evidence.photos[i];
    counts.push_back(static_cast<double>(photo.num_features));
    if (scene.HasFewFeatures(photo) && !scene.groups.registered[i] &&
        !scene.IsBlurred(photo)) {
      weak.push_back(i);
    }
  }
  const double median = UpperMedian(counts);
  const bool all =
      median < static_cast<double>(scene.options.few_features) && !scene.good();
  if (!all && weak.empty()) return;
  Finding finding;
  finding.kind = FindingKind::kTooLittleTexture;
  finding.severity = Severity::kDegrading;
  finding.evidence = {{"median_features", median},
                      {"photos_with_few", static_cast<double>(weak.size())},
                      {"few", static_cast<double>(scene.options.few_features)}};
  finding.advice =
      "show more of the textured surroundings in each photo, or put patterned "
      "things (newspaper, a patterned cloth) into the scene";
  if (all) {
    // Nothing to be found by looking harder.
    finding.hopeless = median < 15;
    finding.message =
        "the scene has too little texture: half of the photos "
        "have fewer than " +
        std::to_string(static_cast<int64_t>(median) + 1) +
        " features, where some hundreds are needed";
  } else {
    finding.photos = scene.Names(weak);
    finding.message = SomeNames(finding.photos) +
                      (weak.size() == 1 ? " shows" : " show") +
                      " too little texture (fewer than " +
                      std::to_string(scene.options.few_features) + " features)";
  }
  findings->push_back(std::move(finding));
}

// A model that hangs on a few points per photo: its poses cannot be trusted.
void FindThinModel(const DiagnosedScene& scene,
                   std::vector<Finding>* findings) {
  if (scene.models.empty() || scene.registered == 0) return;
  size_t observations = 0;
  for (const Point3D& point : scene.models[0].points3d) {
    observations += point.track.size();
  }
  const double each =
      static_cast<double>(observations) / static_cast<double>(scene.registered);
  if (each >= kFewObservations) return;
  Finding finding;
  finding.kind = FindingKind::kTooLittleTexture;
  finding.severity = Severity::kFatal;
  finding.evidence = {{"points_per_photo", each}, {"few", kFewObservations}};
  finding.message = "the model hangs on too little: a photo sees " +
                    FormatSignificant(each, 3) +
                    " of its points on average, so that its poses cannot be "
                    "trusted";
  finding.advice =
      "take sharper photos, with more textured surroundings in each";
  findings->push_back(std::move(finding));
}

void FindNoBaseline(const DiagnosedScene& scene,
                    std::vector<Finding>* findings) {
  const TurningOnTheSpot& turning = scene.turning;
  Finding finding;
  finding.evidence = {{"pairs", static_cast<double>(turning.pairs)},
                      {"homography_share", turning.homography_share},
                      {"stretch", turning.stretch}};
  if (turning.certain() && !scene.HasDepth()) {
    finding.kind = FindingKind::kNoBaseline;
    finding.severity = Severity::kFatal;
    finding.hopeless = true;
    finding.message =
        "the camera only turned on the spot (a rotation explains " +
        FormatPercent(turning.homography_share) +
        " of the matching pairs), so that depth cannot be measured";
    finding.advice =
        "walk around the scene instead, so that each part is seen from well "
        "apart positions";
    findings->push_back(std::move(finding));
    return;
  }
  // Harmless as long as photos that match are registered.
  if (turning.pairs < 3 || turning.homography_share < 0.85 ||
      !scene.LinkedPhotosMissing()) {
    return;
  }
  finding.kind = FindingKind::kPlanarScene;
  finding.severity = Severity::kDegrading;
  finding.message = "nearly everything seen lies in one plane (" +
                    FormatPercent(turning.homography_share) +
                    " of the matching pairs), which leaves the lens and the "
                    "depth uncertain";
  finding.advice =
      "add photos at a slant, and of things in front of or behind the plane";
  findings->push_back(std::move(finding));
}

// Strongest pair between the group and photos outside, in matches.
int64_t StrongestLink(const DiagnosedScene& scene, int group) {
  int64_t strongest = 0;
  for (const PairEvidence& pair : scene.evidence.pairs) {
    if ((scene.groups.group[pair.first] == group) !=
        (scene.groups.group[pair.second] == group)) {
      strongest = std::max(strongest, pair.num_matches);
    }
  }
  return strongest;
}

void FindSeparateScenes(const DiagnosedScene& scene,
                        std::vector<Finding>* findings) {
  const size_t main =
      scene.groups.members.empty() ? 0 : scene.groups.members[0].size();
  for (size_t g = 1; g < scene.groups.members.size(); ++g) {
    const std::vector<size_t>& members = scene.groups.members[g];
    if (members.size() < kMinGroup) continue;
    Finding finding;
    finding.kind = FindingKind::kSeparateScenes;
    finding.severity = Severity::kDegrading;
    finding.photos = scene.Names(members);
    const int64_t link = StrongestLink(scene, static_cast<int>(g));
    finding.evidence = {
        {"photos", static_cast<double>(members.size())},
        {"main_photos", static_cast<double>(main)},
        {"strongest_link", static_cast<double>(link)},
        {"weakest_link_that_counts", static_cast<double>(kMinLink)}};
    finding.message =
        std::to_string(members.size()) + " photos (" +
        SomeNames(finding.photos) +
        ") match each other but none of the other " + std::to_string(main) +
        ": they seem to show another scene, or a part that no photo connects";
    finding.advice =
        "put the photos of another scene into a folder of their own, or add "
        "photos that show both parts";
    findings->push_back(std::move(finding));
  }
}

void FindNoOverlap(const DiagnosedScene& scene,
                   std::vector<Finding>* findings) {
  std::vector<size_t> alone;
  for (size_t i = 0; i < scene.count(); ++i) {
    const PhotoEvidence& photo = scene.evidence.photos[i];
    const size_t size = scene.groups.members[scene.groups.group[i]].size();
    if (size < kMinGroup && !scene.groups.registered[i] &&
        !scene.HasFewFeatures(photo) && !scene.IsBlurred(photo)) {
      alone.push_back(i);
    }
  }
  if (alone.empty()) return;
  Finding finding;
  finding.kind = FindingKind::kNoOverlap;
  finding.severity = Severity::kDegrading;
  finding.evidence = {{"photos", static_cast<double>(alone.size())},
                      {"all_photos", static_cast<double>(scene.count())}};
  finding.photos = scene.Names(alone);
  if (alone.size() * 2 > scene.count()) {
    finding.message = std::to_string(alone.size()) + " of " +
                      std::to_string(scene.count()) +
                      " photos show nothing that two others show as well";
  } else {
    finding.message = SomeNames(finding.photos) +
                      (alone.size() == 1 ? " overlaps" : " overlap") +
                      " too little with the other photos";
  }
  finding.advice =
      "take photos in between, each showing two thirds of what the one before "
      "it shows";
  findings->push_back(std::move(finding));
}

// A finding about photos whose place relative to the others is not known.
Finding AboutPlaces(FindingKind kind,
                    const DiagnosedScene& scene,
                    const std::vector<std::string>& names) {
  Finding finding;
  finding.kind = kind;
  finding.severity = Severity::kDegrading;
  finding.photos = names;
  finding.evidence = {{"photos", static_cast<double>(names.size())},
                      {"main_photos", static_cast<double>(scene.registered)}};
  return finding;
}

void FindUnplaced(const DiagnosedScene& scene, std::vector<Finding>* findings) {
  if (scene.evidence.unplaced.empty()) return;
  Finding finding =
      AboutPlaces(FindingKind::kLookAlikes, scene, scene.evidence.unplaced);
  finding.message = "where " + SomeNames(finding.photos) +
                    " belong relative to the other photos is uncertain: parts "
                    "of the scene look alike, or something in it moved, and "
                    "more speaks against the one model that joined them than "
                    "for it";
  finding.advice =
      "add photos that show the parts that look alike together with what tells "
      "them apart, and take away what moves";
  findings->push_back(std::move(finding));
}

void FindUncertain(const DiagnosedScene& scene,
                   std::vector<Finding>* findings) {
  const std::vector<std::string>& names = scene.evidence.uncertain;
  if (names.empty()) return;
  Finding finding = AboutPlaces(FindingKind::kUncertainPoses, scene, names);
  finding.message = "where " + SomeNames(names) +
                    (names.size() == 1 ? " belongs" : " belong") +
                    " is uncertain: it depends on the photos with which a "
                    "mapping begins";
  finding.advice =
      "take more photos between these and the others, each showing two thirds "
      "of what the one before it shows";
  findings->push_back(std::move(finding));
}

}  // namespace

std::vector<Finding> Diagnose(const SceneEvidence& evidence,
                              const std::vector<Reconstruction>& models,
                              const DiagnosisOptions& options) {
  const DiagnosedScene scene(evidence, models, options);
  std::vector<Finding> findings;
  // Causes before their consequences.
  FindTooFewPhotos(scene, &findings);
  FindNoBaseline(scene, &findings);
  FindBlur(scene, &findings);
  FindLittleTexture(scene, &findings);
  FindThinModel(scene, &findings);
  FindSeparateScenes(scene, &findings);
  FindNoOverlap(scene, &findings);
  FindUnplaced(scene, &findings);
  FindUncertain(scene, &findings);
  std::stable_sort(
      findings.begin(), findings.end(), [](const Finding& a, const Finding& b) {
        return a.severity > b.severity;
      });
  return findings;
}

}  // namespace freegs::sfm
