// SPDX-License-Identifier: BSD-3-Clause
// Mapping without misleading matches.

#include "sfm/mapping/reconcile.h"

#include <utility>

#include "sfm/lookalikes/view_graph.h"
#include "sfm/matching/match_database.h"

namespace freegs::sfm {
namespace {

namespace fs = std::filesystem;

constexpr int kMaxRounds = 3;
constexpr char kName[] = "without look-alikes";

StatusOr<AttemptResult> MapWithout(const StepContext& context,
                                   const fs::path& database,
                                   const fs::path& folder,
                                   size_t registered,
                                   Contradictions found) {
  const fs::path trusted = folder / "trusted.db";
  FREEGS_RETURN_IF_ERROR(CopyDatabase(database, trusted));
  AttemptResult result;
  int64_t removed = 0;
  for (int round = 0; round < kMaxRounds && !found.suspects.empty(); ++round) {
    FREEGS_RETURN_IF_ERROR(RemoveVerifiedPairs(trusted, found.suspects));
    removed += static_cast<int64_t>(found.suspects.size());
    FREEGS_ASSIGN_OR_RETURN(
        std::vector<Reconstruction> again,
        MapBest(context, trusted, folder / "mapper", registered));
    if (again.empty()) break;
    // Against what is still trusted.
    FREEGS_ASSIGN_OR_RETURN(Contradictions next,
                            FindContradictions(again[0], trusted));
    const bool fewer = next.strongest.size() < found.strongest.size();
    const size_t now = again[0].images.size();
    if (!fewer || now * 10 < registered * 9) break;
    registered = now;
    result.models = std::move(again);
    found = std::move(next);
  }
  RemoveDatabase(trusted);
  result.counts = {
      {"contradictions", static_cast<int64_t>(found.strongest.size())},
      {"removed", removed}};
  return result;
}

}  // namespace

StatusOr<Reconciled> Reconcile(const StepContext& context,
                               const fs::path& database,
                               const std::vector<Reconstruction>& models,
                               AttemptStore* store) {
  Reconciled reconciled;
  if (models.empty()) return reconciled;
  FREEGS_ASSIGN_OR_RETURN(Contradictions found,
                          FindContradictions(models[0], database));
  reconciled.before = reconciled.contradictions = found.strongest.size();
  if (found.strongest.empty()) return reconciled;
  FREEGS_ASSIGN_OR_RETURN(AttemptResult result, store->Run(kName, [&] {
    return MapWithout(context,
                      database,
                      store->Folder(kName),
                      models[0].images.size(),
                      std::move(found));
  }));
  reconciled.models = std::move(result.models);
  reconciled.contradictions =
      static_cast<size_t>(result.counts["contradictions"]);
  reconciled.removed = static_cast<size_t>(result.counts["removed"]);
  return reconciled;
}

}  // namespace freegs::sfm
