// SPDX-License-Identifier: BSD-3-Clause
// From the instance that was clicked to what it is a part of, or to its part
// that was clicked.

#ifndef FREEGS_STAGES_QUERY_QUERY_LEVEL_H_
#define FREEGS_STAGES_QUERY_QUERY_LEVEL_H_

#include <filesystem>

#include "core/parallel.h"
#include "core/pinhole.h"
#include "core/status.h"
#include "semantics/queries/click_query.h"
#include "stages/query/query_scene.h"

namespace freegs::stages {

// A pixel of a view that shows an instance.
struct ClickedInstance {
  const View& view;
  semantics::Pixel pixel = {};
  int id = 0;
};

// Adds to the scene, with an id of its own, the region `level` levels above the
// instance in bootstrap/hierarchy.json, or below it at this pixel for negative
// levels. Its Gaussians no longer have their old instances. Returns the id.
// kBadInput if the file is missing, malformed or of another scene;
// kInvalidArgument if the pixel shows no part of the instance that the file
// knows, where the part matters (downwards) or there is none.
StatusOr<int> AddLevel(const std::filesystem::path& workspace,
                       const ClickedInstance& clicked,
                       int level,
                       ThreadPool& pool,
                       QueryScene* scene);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_QUERY_QUERY_LEVEL_H_
