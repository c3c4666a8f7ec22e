// SPDX-License-Identifier: BSD-3-Clause
// Loads from a workspace what a question needs. The command `query`
// (stages/commands/query_command.cc) does
//
//   ParseQueryRequest(arguments)         query_request.h
//   LoadQueryScene(request, messages, &scene)
//   FindAnswer(request, ...)             query_engine.h
//   WriteQueryMasks(task, ...)           query_masks.h
//   ToJson(answer, scene.instances)      query_answer.h

#ifndef FREEGS_STAGES_QUERY_QUERY_SCENE_H_
#define FREEGS_STAGES_QUERY_QUERY_SCENE_H_

#include <cstdint>
#include <optional>
#include <ostream>
#include <vector>

#include "core/pinhole.h"
#include "core/status.h"
#include "semantics/instances/hierarchy.h"
#include "semantics/instances/instances.h"
#include "semantics/queries/instance_features.h"
#include "stages/query/query_request.h"
#include "stages/scene/workspace_scene.h"

namespace freegs::stages {

struct QueryScene {
  std::vector<semantics::Instance> instances;
  std::vector<uint8_t> is_background;  // By id - 1; 1 for large planes.

  // Loaded for questions by text and by example.
  std::optional<semantics::InstanceFeatures> features;

  // Loaded for questions by click and by box, and for masks.
  std::optional<WorkspaceScene> scene;
  std::vector<int32_t> labels;  // One per Gaussian, -1 for none.
  std::vector<View> views;      // The views to show, limited to --size.

  // Clicks and boxes are in one of these, which have their own size.
  std::vector<View> photos;
  std::vector<View> file_views;  // The views of --cameras.

  // Read by the first click with a level.
  std::optional<semantics::Hierarchy> hierarchy;
};

// Loads what the request needs and `scene` does not have yet. kBadInput names
// the file that is missing, malformed or does not fit another one, and the
// stage that writes it. `messages` is told what ViewsToRender says.
Status LoadQueryScene(const QueryRequest& request,
                      std::ostream& messages,
                      QueryScene* scene);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_QUERY_QUERY_SCENE_H_
