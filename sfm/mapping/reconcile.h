// SPDX-License-Identifier: BSD-3-Clause
// Getting rid of matches between things that only look alike.

#ifndef FREEGS_SFM_MAPPING_RECONCILE_H_
#define FREEGS_SFM_MAPPING_RECONCILE_H_

#include <cstddef>
#include <filesystem>
#include <vector>

#include "core/status.h"
#include "sfm/colmap/colmap_steps.h"
#include "sfm/mapping/attempt.h"

namespace freegs::sfm {

struct Reconciled {
  // Models that contradict fewer of the strongest matches; empty when there
  // are none, and the ones given are as good as it gets.
  std::vector<Reconstruction> models;

  size_t before = 0;          // Contradicted matches of the model given.
  size_t contradictions = 0;  // Those that remain.
  size_t removed = 0;         // Matching pairs that were not believed.
};

// Maps again without the matches that put photos in places which their
// strongest matches contradict (see view_graph.h), as long as that helps.
// models: the best first; from the database.
StatusOr<Reconciled> Reconcile(const StepContext& context,
                               const std::filesystem::path& database,
                               const std::vector<Reconstruction>& models,
                               AttemptStore* store);

}  // namespace freegs::sfm

#endif  // FREEGS_SFM_MAPPING_RECONCILE_H_
