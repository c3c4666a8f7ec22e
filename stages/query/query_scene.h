// SPDX-License-Identifier: BSD-3-Clause
// What a workspace knows about its instances, as far as a question needs it.

#ifndef FREEGS_STAGES_QUERY_QUERY_SCENE_H_
#define FREEGS_STAGES_QUERY_QUERY_SCENE_H_

#include <cstdint>
#include <optional>
#include <ostream>
#include <vector>

#include "core/pinhole.h"
#include "core/status.h"
#include "semantics/instances/instances.h"
#include "semantics/queries/instance_features.h"
#include "stages/query/query_request.h"
#include "stages/scene/workspace_scene.h"

namespace freegs::stages {

struct QueryScene {
  std::vector<semantics::Instance> instances;
  std::vector<uint8_t> is_background;  // By id - 1.

  std::optional<semantics::InstanceFeatures> features;  // Text and example.

  // Of click and box, and for masks.
  std::optional<WorkspaceScene> scene;
  std::vector<int32_t> labels;  // Per Gaussian.
  std::vector<View> views;      // To show; clicks and boxes name one of them,
  std::vector<View> photos;     // or one of these.
};

// kBadInput names the file that is missing, malformed or at odds with another,
// and the stage that writes it. `messages` as ViewsToRender.
StatusOr<QueryScene> LoadQueryScene(const QueryRequest& request,
                                    std::ostream& messages);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_QUERY_QUERY_SCENE_H_
