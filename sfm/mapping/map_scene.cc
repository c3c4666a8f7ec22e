// SPDX-License-Identifier: BSD-3-Clause

#include "sfm/mapping/map_scene.h"

#include <algorithm>
#include <string>
#include <utility>

#include "sfm/diagnosis/photo_reasons.h"
#include "sfm/lookalikes/view_groups.h"
#include "sfm/mapping/initial_pair.h"
#include "sfm/mapping/skeleton.h"
#include "sfm/matching/match_database.h"

namespace freegs::sfm {
namespace {

namespace fs = std::filesystem;
using Models = std::vector<Reconstruction>;

// Photos that the best model lacks. Blurred ones are not counted.
struct LeftOut {
  size_t photos = 0;
  size_t matching = 0;  // Those of them that match photos of the model.
};

LeftOut CountLeftOut(const SceneEvidence& evidence, const Models& models) {
  const PhotoGroups groups = GroupByMatches(evidence, models);
  // Even few matches with a photo of the model may be enough to place another.
  std::vector<bool> linked(evidence.photos.size(), false);
  for (const PairEvidence& pair : evidence.pairs) {
    if (groups.registered[pair.first]) linked[pair.second] = true;
    if (groups.registered[pair.second]) linked[pair.first] = true;
  }
  const std::vector<bool> blurred = FindBlurredPhotos(evidence);
  LeftOut left_out;
  for (size_t i = 0; i < evidence.photos.size(); ++i) {
    if (groups.registered[i] || blurred[i]) continue;
    ++left_out.photos;
    const size_t size = groups.members[groups.group[i]].size();
    const bool main = groups.group[i] == 0 && !models.empty();
    if (!main && size >= kMinGroup) continue;  // A part of its own.
    if (main || linked[i]) ++left_out.matching;
  }
  return left_out;
}

// Why lower thresholds may help; empty if they cannot or need not.
std::string WhyAgain(const SceneEvidence& evidence,
                     const Models& models,
                     const DiagnosisOptions& diagnosis) {
  const LeftOut left_out = CountLeftOut(evidence, models);
  const auto got = static_cast<double>(NumRegistered(models));
  const auto wanted = got + static_cast<double>(left_out.photos);
  if (got > 0 && got >= kGoodShare * wanted) return {};
  const auto findings = Diagnose(evidence, models, diagnosis);
  if (std::any_of(findings.begin(), findings.end(), [](const Finding& finding) {
        return finding.hopeless;
      })) {
    return {};
  }
  if (models.empty()) return "there is no model yet";
  if (left_out.matching == 0) return {};
  return std::to_string(left_out.matching) +
         (left_out.matching == 1 ? " photo" : " photos") +
         " left out, though matching the model";
}

StatusOr<bool> IsBetter(const Models& after,
                        const Models& before,
                        const fs::path& database) {
  if (after.empty()) return false;
  if (before.empty()) return true;
  const Attempt old_attempt = DescribeAttempt("", "", before);
  const Attempt new_attempt = DescribeAttempt("", "", after);
  if (new_attempt.registered < old_attempt.registered) return false;
  if (new_attempt.registered == old_attempt.registered &&
      (new_attempt.points * 10 < old_attempt.points * 12 ||
       new_attempt.mean_error_px > 1.2 * old_attempt.mean_error_px)) {
    return false;
  }
  FREEGS_ASSIGN_OR_RETURN(const ViewGroups parts,
                          GroupViews(after[0], database));
  if (parts.consistent()) return true;
  FREEGS_ASSIGN_OR_RETURN(const ViewGroups parts_before,
                          GroupViews(before[0], database));
  return !parts_before.consistent();
}

// Whether the photos outside of the largest group are too few for a model. A
// part of the photos makes one model only.
bool ShowOnePlace(const SceneEvidence& evidence) {
  const PhotoGroups groups = GroupByMatches(evidence, {});
  return groups.members.size() < 2 || groups.members[1].size() < kUsualMinModel;
}

// Maps many photos by a part of them. Leaves the scene without a model if that
// cannot be done, if another way might place more photos, or if the model does
// not hold together, which that of all photos may do.
Status MapPart(const StepContext& context,
               const fs::path& database,
               const DiagnosisOptions& diagnosis,
               AttemptStore* store,
               MappedScene* scene) {
  const auto photos = static_cast<int64_t>(context.input.photos.size());
  if (!context.options.MayMapPart(photos) || !ShowOnePlace(scene->evidence)) {
    return {};
  }
  const std::string name = "mapping, part of the photos first";
  FREEGS_ASSIGN_OR_RETURN(
      AttemptResult made, store->Try(name, [&]() -> StatusOr<AttemptResult> {
        AttemptResult result;
        FREEGS_ASSIGN_OR_RETURN(
            result.models,
            MapFromSkeleton(context, database, store->Folder(name) / "mapper"));
        return result;
      }));
  if (made.models.empty() && made.problem.empty()) return {};
  Attempt attempt = DescribeAttempt(name, "", made.models);
  attempt.problem = std::move(made.problem);
  if (!made.models.empty()) {
    FREEGS_ASSIGN_OR_RETURN(const ViewGroups parts,
                            GroupViews(made.models[0], database));
    attempt.problem = parts.consistent()
                          ? WhyAgain(scene->evidence, made.models, diagnosis)
                          : "its photos do not hold together";
  }
  attempt.kept = attempt.problem.empty();
  if (attempt.kept) scene->models = std::move(made.models);
  scene->attempts.push_back(std::move(attempt));
  return {};
}

}  // namespace

StatusOr<MappedScene> MapScene(const StepContext& context,
                               const fs::path& database,
                               const DiagnosisOptions& diagnosis,
                               AttemptStore* store) {
  const auto map =
      [&](const std::string& name,
          const MapperOptions& options) -> StatusOr<AttemptResult> {
    AttemptResult made;
    FREEGS_ASSIGN_OR_RETURN(
        made.models,
        MapPhotos(context, database, store->Folder(name) / "mapper", options));
    return made;
  };
  MappedScene scene;
  {
    FREEGS_ASSIGN_OR_RETURN(const MatchDatabase matches,
                            MatchDatabase::Open(database));
    FREEGS_ASSIGN_OR_RETURN(scene.evidence,
                            CollectEvidence(context.input.photos, matches));
  }
  FREEGS_RETURN_IF_ERROR(MapPart(context, database, diagnosis, store, &scene));
  if (!scene.models.empty()) return scene;
  const std::string plain = kPlainMapping;
  FREEGS_ASSIGN_OR_RETURN(
      AttemptResult first, store->Run(plain, [&]() -> StatusOr<AttemptResult> {
        AttemptResult made;
        FREEGS_ASSIGN_OR_RETURN(
            made.models,
            MapFromBestPair(
                context, database, store->Folder(plain) / "mapper"));
        return made;
      }));
  scene.models = std::move(first.models);
  scene.attempts.push_back(DescribeAttempt(plain, "", scene.models));
  scene.attempts.back().kept = !scene.models.empty();
  const auto again = [&](const std::string& name,
                         const std::string& why,
                         MapperOptions options) -> Status {
    options.step = "mapping, " + name;
    options.further = true;
    options.relaxed = true;
    FREEGS_ASSIGN_OR_RETURN(AttemptResult made, store->Try(name, [&] {
      return map(name, options);
    }));
    Attempt attempt = DescribeAttempt(name, why, made.models);
    attempt.problem = std::move(made.problem);
    FREEGS_ASSIGN_OR_RETURN(attempt.kept,
                            IsBetter(made.models, scene.models, database));
    if (attempt.kept) {
      scene.models = std::move(made.models);
      scene.options = std::move(options);
    }
    scene.attempts.push_back(std::move(attempt));
    return {};
  };
  const std::string why = WhyAgain(scene.evidence, scene.models, diagnosis);
  if (why.empty()) return scene;
  FREEGS_RETURN_IF_ERROR(again("lower thresholds", why, {}));
  if (NumRegistered(scene.models) >= kUsualMinModel) return scene;
  const std::string still = WhyAgain(scene.evidence, scene.models, diagnosis);
  if (still.empty()) return scene;
  FREEGS_RETURN_IF_ERROR(again("small models", still, {.small_models = true}));
  return scene;
}

}  // namespace freegs::sfm
