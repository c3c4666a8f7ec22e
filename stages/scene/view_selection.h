// SPDX-License-Identifier: BSD-3-Clause
// The views that a command shows: those of the photos, or those of a file.

#ifndef FREEGS_STAGES_SCENE_VIEW_SELECTION_H_
#define FREEGS_STAGES_SCENE_VIEW_SELECTION_H_

#include <ostream>
#include <string>
#include <vector>

#include "core/pinhole.h"
#include "core/status.h"
#include "stages/scene/workspace_scene.h"

namespace freegs::stages {

// The views of all photos by name, at the photographs' own size.
std::vector<View> PhotoViews(const WorkspaceScene& scene);

// `count` of the views, evenly spread, in their order. All of them when there
// are not more.
std::vector<View> SpreadViews(const std::vector<View>& views, int count);

struct ViewSelection {
  std::string cameras = {};  // Camera file; empty for the photos' views.
  bool align = true;         // See FileViews.

  // Longest side in pixels at most of the file's and of the photos' views; 0 is
  // their own size.
  int max_side = 0;
  int photo_max_side = 0;

  std::string command = {};  // For messages.
};

// kBadInput also for pictures of more than 100 million pixels.
StatusOr<std::vector<View>> ViewsToRender(const WorkspaceScene& scene,
                                          const ViewSelection& selection,
                                          std::ostream& messages);

// The view of that name, or the only one of that name without its extension.
// kInvalidArgument, with names like it, when there is none.
StatusOr<View> FindView(const std::vector<View>& views,
                        const std::string& name);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_SCENE_VIEW_SELECTION_H_
