// SPDX-License-Identifier: BSD-3-Clause
// Whether a reconstruction fits the matches it was made from. Scenes with
// repeated structure (two equal chairs, a table whose grain repeats after half
// a turn) have photos that match well and show different places; a mapper that
// trusts one such match puts photos where they never were, with a perfect
// reprojection error. The strong matches it then has to ignore give it away.

#ifndef FREEGS_SFM_LOOKALIKES_VIEW_GRAPH_H_
#define FREEGS_SFM_LOOKALIKES_VIEW_GRAPH_H_

#include <cstdint>
#include <filesystem>
#include <utility>
#include <vector>

#include "core/status.h"
#include "sfm/matching/match_database.h"
#include "sfm/scene/reconstruction.h"

namespace freegs::sfm {

// A pair of registered images with verified matches. Of these, where both
// features have a 3D point: it is the same, or it is not.
struct PairAgreement {
  uint32_t image_id1 = 0;
  uint32_t image_id2 = 0;
  int64_t matches = 0;
  int64_t agreeing = 0;
  int64_t contradicting = 0;

  bool agrees() const { return agreeing > contradicting; }
  // By more than splinters of a point that was triangulated twice.
  bool contradicts() const {
    return contradicting >= 30 && contradicting > 4 * agreeing;
  }
};

StatusOr<std::vector<PairAgreement>> MeasureAgreement(
    const Reconstruction& model, const MatchDatabase& database);

struct Contradictions {
  // Pairs of the maximum spanning tree by number of matches that the model
  // contradicts. The photo that matches another best shows the same place, if
  // any does; a model without repeated structure has none of these.
  std::vector<std::pair<uint32_t, uint32_t>> strongest;

  // Pairs to be distrusted instead: they agree with the model across the parts
  // into which the contradicted pairs cut the tree.
  std::vector<std::pair<uint32_t, uint32_t>> suspects;
};

Contradictions FindContradictions(const std::vector<PairAgreement>& pairs);

// The same from a database of matches.
StatusOr<Contradictions> FindContradictions(
    const Reconstruction& model, const std::filesystem::path& database);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_LOOKALIKES_VIEW_GRAPH_H_
