// SPDX-License-Identifier: BSD-3-Clause
// Writes the answer of a query as pictures: the found instances in every view.

#ifndef FREEGS_STAGES_QUERY_QUERY_MASKS_H_
#define FREEGS_STAGES_QUERY_QUERY_MASKS_H_

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "core/cancellation.h"
#include "core/function_ref.h"
#include "core/parallel.h"
#include "core/status.h"
#include "stages/query/query_answer.h"
#include "stages/scene/workspace_scene.h"

namespace freegs::stages {

struct QueryMasksTask {
  const WorkspaceScene& scene;
  std::span<const int32_t> labels;  // One per Gaussian, -1 for none.
  const std::vector<View>& views;
  std::vector<int> ids;  // Instances to show; without any, masks are empty.

  // The folder with the photographs that overlays are drawn on; empty draws
  // them on renderings.
  std::filesystem::path photos;
  std::filesystem::path out;  // The folder to write to.
};

// Removes from the folder `out` the masks that its query.json lists, their
// overlays, and query.json itself, so that no file of an earlier answer stays
// among those of the next one. Does nothing where there is none.
void RemoveEarlierAnswer(const std::filesystem::path& out);

// Writes out/masks/VIEW.png for every view: 8-bit grey, 255 where one of the
// instances has the largest sum of blending weights, else 0. Also writes
// out/overlay/VIEW.jpg for at most six of the views that see an instance.
// `progress` is told how many views are done. kInterrupted when cancelled; what
// was written is removed then, and after any other error.
StatusOr<std::vector<MaskedView>> WriteQueryMasks(
    const QueryMasksTask& task,
    const CancellationToken& cancellation,
    FunctionRef<void(size_t)> progress,
    ThreadPool& pool);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_QUERY_QUERY_MASKS_H_
