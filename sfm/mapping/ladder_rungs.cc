// SPDX-License-Identifier: BSD-3-Clause
// Other ways of matching and mapping.

#include "sfm/mapping/ladder_rungs.h"

#include <algorithm>
#include <set>
#include <system_error>
#include <utility>

#include "sfm/matching/match_database.h"
#include "sfm/scene/model_io.h"

namespace freegs::sfm {
namespace {

namespace fs = std::filesystem;
using Models = std::vector<Reconstruction>;

constexpr double kLooseRatio = 0.9;      // Instead of 0.8.
constexpr double kLooseAngle = 0.9;      // Instead of 0.7, radians.
constexpr double kLowContrast = 0.0025;  // COLMAP's default is 0.0067.

fs::path Scratch(const RungInput& input) { return input.folder / "mapper"; }

StatusOr<AttemptResult> MapWith(const RungInput& input, Mapping mapping) {
  mapping.step = "mapping, " + input.name;
  AttemptResult result;
  FREEGS_ASSIGN_OR_RETURN(
      result.models,
      MapPhotos(input.context, input.database.path, Scratch(input), mapping));
  return result;
}

// Maps the rung's own database, for which these pairs were matched. As long as
// there is no model at all, lower thresholds are tried as well; otherwise not,
// because they take long on photos that do not belong together.
StatusOr<AttemptResult> MapOwnDatabase(const RungInput& input,
                                       const StepContext& context,
                                       MatchedPairs pairs) {
  const fs::path database = AttemptDatabase(input.folder);
  AttemptResult result;
  result.has_database = true;
  result.pairs = std::move(pairs);
  StatusOr<Models> models =
      input.models.empty()
          ? MapBest(
                context, database, Scratch(input), context.input.photos.size())
          : MapPhotos(context, database, Scratch(input), {});
  if (!models.ok()) return models.status();
  result.models = *std::move(models);
  return result;
}

// Matches the features of the rung's own database, and maps.
StatusOr<AttemptResult> MatchAndMap(const RungInput& input,
                                    const StepContext& context) {
  FREEGS_ASSIGN_OR_RETURN(
      MatchedPairs pairs,
      MatchFeatures(context, AttemptDatabase(input.folder), {}, [](int) {
        return Status();
      }));
  return MapOwnDatabase(input, context, std::move(pairs));
}

StatusOr<AttemptResult> MatchAgain(const RungInput& input,
                                   const SfmOptions& options,
                                   const DescriptorMatchingOptions& matching) {
  StepContext context{input.context.input, options, input.context.colmap};
  context.num_threads = input.context.num_threads;
  context.matching = matching;
  FREEGS_RETURN_IF_ERROR(
      CopyDatabase(input.database.path, AttemptDatabase(input.folder)));
  return MatchAndMap(input, context);
}

}  // namespace

size_t NumShared(const Reconstruction& a, const Reconstruction& b) {
  std::set<std::string> names;
  for (const PosedImage& image : a.images) names.insert(image.name);
  return static_cast<size_t>(std::count_if(
      b.images.begin(), b.images.end(), [&](const PosedImage& image) {
        return names.contains(image.name);
      }));
}

StatusOr<AttemptResult> MapRelaxed(const RungInput& input) {
  Mapping mapping;
  mapping.relaxed = true;
  return MapWith(input, mapping);
}

StatusOr<AttemptResult> MapWithOtherSeed(const RungInput& input) {
  Mapping mapping;
  mapping.seed_offset = 1;
  return MapWith(input, mapping);
}

// Merging leaves two versions of shared photos' points, and no adjustment: the
// mapper then goes on from there, which does both.
StatusOr<AttemptResult> MergeAll(const RungInput& input) {
  const fs::path folder = input.folder;
  fs::path merged = folder / "start";
  FREEGS_RETURN_IF_ERROR(WriteModel(merged, input.models[0]));
  bool any = false;
  Reconstruction whole = input.models[0];
  for (size_t k = 1; k < input.models.size(); ++k) {
    if (NumShared(whole, input.models[k]) < kSharedPhotos) continue;
    const fs::path other = folder / ("other" + std::to_string(k));
    const fs::path both = folder / ("merged" + std::to_string(k));
    FREEGS_RETURN_IF_ERROR(WriteModel(other, input.models[k]));
    FREEGS_ASSIGN_OR_RETURN(const bool done,
                            MergeModels(input.context, merged, other, both));
    if (!done) continue;
    FREEGS_ASSIGN_OR_RETURN(Reconstruction model, ReadModel(both));
    if (model.images.size() <= whole.images.size()) continue;
    whole = std::move(model);
    merged = both;
    any = true;
  }
  if (!any) return AttemptResult();
  Mapping mapping;
  mapping.start = merged;
  return MapWith(input, mapping);
}

StatusOr<AttemptResult> AddPhotos(const RungInput& input) {
  Mapping mapping;
  mapping.relaxed = true;
  mapping.start = input.folder / "start";
  FREEGS_RETURN_IF_ERROR(WriteModel(mapping.start, input.models[0]));
  return MapWith(input, mapping);
}

StatusOr<AttemptResult> MatchMoreGuided(const RungInput& input) {
  std::set<std::string> registered;
  if (!input.models.empty()) {
    for (const PosedImage& image : input.models[0].images) {
      registered.insert(image.name);
    }
  }
  std::vector<std::pair<uint32_t, uint32_t>> pairs;
  {
    FREEGS_ASSIGN_OR_RETURN(const MatchDatabase database,
                            MatchDatabase::Open(input.database.path));
    FREEGS_ASSIGN_OR_RETURN(const auto photos, database.Photos());
    std::set<uint32_t> missing;
    for (const MatchDatabase::Photo& photo : photos) {
      if (!registered.contains(photo.name)) missing.insert(photo.id);
    }
    FREEGS_ASSIGN_OR_RETURN(const auto verified, database.VerifiedPairs());
    for (const MatchDatabase::VerifiedPair& pair : verified) {
      if (missing.contains(pair.id1) || missing.contains(pair.id2)) {
        pairs.emplace_back(pair.id1, pair.id2);
      }
    }
  }
  if (pairs.empty()) return AttemptResult();
  const fs::path database = AttemptDatabase(input.folder);
  FREEGS_RETURN_IF_ERROR(CopyDatabase(input.database.path, database));
  FREEGS_RETURN_IF_ERROR(MatchGuided(input.context, database, pairs));
  // The same pairs of photos as before.
  std::error_code error;
  fs::copy_file(input.database.path.parent_path() / "pairs.txt",
                input.folder / "pairs.txt",
                error);
  if (error) return InternalError("pairs.txt: " + error.message());
  return MapOwnDatabase(input, input.context, input.database.pairs);
}

StatusOr<AttemptResult> MatchAllPairs(const RungInput& input) {
  SfmOptions options = input.context.options;
  options.pairs.matcher = "exhaustive";
  return MatchAgain(input, options, input.context.matching);
}

StatusOr<AttemptResult> MatchLoosely(const RungInput& input) {
  SfmOptions options = input.context.options;
  if (input.database.pairs.complete()) options.pairs.matcher = "exhaustive";
  return MatchAgain(input, options, {kLooseRatio, kLooseAngle});
}

int LargerImageSize(int size) {
  return std::max(size + size / 2, std::min(2 * size, 1600));
}

StatusOr<AttemptResult> TakeMoreFeatures(const RungInput& input) {
  SfmOptions options = input.context.options;
  if (input.database.pairs.complete()) options.pairs.matcher = "exhaustive";
  options.max_features *= kMoreFeatures;
  options.max_image_size = LargerImageSize(options.max_image_size);
  StepContext context{input.context.input, options, input.context.colmap};
  context.num_threads = input.context.num_threads;
  context.peak_threshold = kLowContrast;
  const fs::path database = AttemptDatabase(input.folder);
  FREEGS_ASSIGN_OR_RETURN(const bool numbered,
                          RegisterPhotos(context, database));
  FREEGS_RETURN_IF_ERROR(
      ExtractFeatures(context, database, numbered ? context.num_threads : 1));
  FREEGS_ASSIGN_OR_RETURN(AttemptResult result, MatchAndMap(input, context));
  result.image_size = options.max_image_size;
  return result;
}

// COLMAP 4's global mapper; for many photos, the hierarchical one that older
// releases have.
StatusOr<AttemptResult> MapOtherwise(const RungInput& input) {
  Mapping mapping;
  mapping.command = input.context.colmap.HasCommand("global_mapper")
                        ? "global_mapper"
                        : "hierarchical_mapper";
  return MapWith(input, mapping);
}

}  // namespace freegs::sfm
