// SPDX-License-Identifier: BSD-3-Clause

#include "sfm/mapping/confirm_poses.h"

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <map>
#include <set>
#include <utility>

#include "sfm/colmap/colmap_steps.h"
#include "sfm/mapping/place_comparison.h"

namespace freegs::sfm {
namespace {

using Models = std::vector<Reconstruction>;

constexpr size_t kMaxMappings = 4;

// With fewer photos, places cannot be compared.
constexpr size_t kMinToCompare = 3;

// Whether two models have the same photos with the same translations, to the
// last digit. Two mappings that began differently never do.
bool AreSame(const Reconstruction& a, const Reconstruction& b) {
  if (a.images.size() != b.images.size()) return false;
  std::map<std::string, Eigen::Vector3d> translations;
  for (const PosedImage& image : a.images) {
    translations[image.name] = image.cam_from_world.translation;
  }
  return std::all_of(b.images.begin(), b.images.end(), [&](const auto& image) {
    const auto found = translations.find(image.name);
    return found != translations.end() &&
           found->second == image.cam_from_world.translation;
  });
}

Reconstruction Without(const Reconstruction& model,
                       const std::vector<std::string>& names) {
  const std::set<std::string> removed(names.begin(), names.end());
  std::vector<uint32_t> ids;
  for (const PosedImage& image : model.images) {
    if (!removed.contains(image.name)) ids.push_back(image.id);
  }
  return RestrictTo(model, ids);
}

// Why a further model is not of use beside the others; empty if it is.
std::string WhyOfNoUse(const Models& models, const Models& made) {
  if (made.empty()) return "no model came of it";
  if (2 * NumRegistered(made) < models[0].images.size()) {
    return "it has too few photos to compare";
  }
  for (const Reconstruction& model : models) {
    if (AreSame(model, made[0])) return "it is the same model again";
  }
  return {};
}

// What is said about a further model that is of use.
std::string Compared(const Reconstruction& first,
                     const Reconstruction& further) {
  const PlaceComparison places = ComparePlaces(first, further);
  return "it has " + std::to_string(places.alike.size()) + " of " +
         std::to_string(places.alike.size() + places.elsewhere.size()) +
         " photos where the first model has them";
}

// Fills in all but the attempts. The best candidate takes the place of the
// first of `models`, without uncertain photos if at least `enough` are left.
void TakeBest(const Models& candidates,
              Consensus consensus,
              const Models& models,
              size_t enough,
              ConfirmedPoses* result) {
  result->replaced = consensus.best > 0;
  result->witnessed = consensus.witnessed;
  result->uncertain = std::move(consensus.uncertain);
  const Reconstruction& chosen = candidates[consensus.best];
  const size_t certain = chosen.images.size() - result->uncertain.size();
  const bool remove =
      !result->uncertain.empty() && certain >= std::max(enough, kMinToCompare);
  if (!result->replaced && !remove) return;
  result->models.push_back(remove ? Without(chosen, result->uncertain)
                                  : chosen);
  if (result->replaced) {
    AddOthers(models, &result->models);
    return;
  }
  result->models.insert(result->models.end(), models.begin() + 1, models.end());
}

}  // namespace

StatusOr<ConfirmedPoses> ConfirmPoses(const Models& models,
                                      size_t enough,
                                      const MapAgainFn& map_again) {
  ConfirmedPoses result;
  const size_t registered = NumRegistered(models);
  if (registered < kMinToCompare || registered > kMostPhotosToConfirm) {
    return result;
  }
  Models candidates = {models[0]};
  std::vector<size_t> attempt_of = {0};  // By candidate; not that of the first.
  std::vector<size_t> mapping_of;        // By attempt: a repair has another's.
  Consensus consensus = FindConsensus(candidates);
  const auto take = [&](const std::string& name, AttemptResult made) {
    const size_t mapping = result.attempts.size();
    Attempt attempt = DescribeAttempt(
        name, "whether poses depend on the first two photos", made.models);
    attempt.problem = std::move(made.problem);
    const std::string no_use = WhyOfNoUse(candidates, made.models);
    if (no_use.empty()) {
      attempt.problem = Compared(candidates[0], made.models[0]);
      candidates.push_back(std::move(made.models[0]));
      attempt_of.push_back(mapping);
      consensus = FindConsensus(candidates);
    } else if (attempt.problem.empty()) {
      attempt.problem = no_use;
    }
    result.attempts.push_back(std::move(attempt));
    std::move(made.repairs.begin(),
              made.repairs.end(),
              std::back_inserter(result.attempts));
    mapping_of.resize(result.attempts.size(), mapping);
  };
  bool pairs_left = true;
  for (size_t skip = 1;
       skip <= kMaxMappings && pairs_left && !consensus.witnessed;
       ++skip) {
    const std::string name = "start " + std::to_string(skip + 1);
    FREEGS_ASSIGN_OR_RETURN(std::optional<AttemptResult> made,
                            map_again(name, skip));
    pairs_left = made && !made->models.empty();
    if (made) take(name, *std::move(made));
    if (!pairs_left) {
      const std::string last = "start by COLMAP";
      FREEGS_ASSIGN_OR_RETURN(made, map_again(last, std::nullopt));
      if (made) take(last, *std::move(made));
    }
  }
  for (size_t i = 0; i < result.attempts.size(); ++i) {
    Attempt& attempt = result.attempts[i];
    const bool kept =
        consensus.best > 0 && mapping_of[i] == attempt_of[consensus.best];
    if (kept && mapping_of[i] == i) {
      attempt.kept = true;
      attempt.problem.clear();
    } else if (!kept && attempt.kept) {
      attempt.kept = false;
      attempt.problem = "the mapping that it repaired is not kept";
    }
  }
  TakeBest(candidates, std::move(consensus), models, enough, &result);
  return result;
}

}  // namespace freegs::sfm
