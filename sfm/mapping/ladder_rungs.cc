// SPDX-License-Identifier: BSD-3-Clause
// Other ways of matching and mapping.

#include "sfm/mapping/ladder_rungs.h"

#include <algorithm>
#include <utility>

#include "sfm/matching/match_database.h"

namespace freegs::sfm {
namespace {

namespace fs = std::filesystem;
using Models = std::vector<Reconstruction>;

constexpr double kLowContrast = 0.0025;  // COLMAP's default is 0.0067.

fs::path Scratch(const RungInput& input) { return input.folder / "mapper"; }

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

}  // namespace

StatusOr<AttemptResult> MapRelaxed(const RungInput& input) {
  Mapping mapping;
  mapping.step = "mapping, " + input.name;
  mapping.relaxed = true;
  AttemptResult result;
  FREEGS_ASSIGN_OR_RETURN(
      result.models,
      MapPhotos(input.context, input.database.path, Scratch(input), mapping));
  return result;
}

StatusOr<AttemptResult> MatchAllPairs(const RungInput& input) {
  SfmOptions options = input.context.options;
  options.pairs.matcher = "exhaustive";
  StepContext context{input.context.input, options, input.context.colmap};
  context.num_threads = input.context.num_threads;
  FREEGS_RETURN_IF_ERROR(
      CopyDatabase(input.database.path, AttemptDatabase(input.folder)));
  return MatchAndMap(input, context);
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

}  // namespace freegs::sfm
