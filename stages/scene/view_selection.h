// SPDX-License-Identifier: BSD-3-Clause
// Chooses the views that a command renders: those of the photos, or those of a
// camera file.

#ifndef FREEGS_STAGES_SCENE_VIEW_SELECTION_H_
#define FREEGS_STAGES_SCENE_VIEW_SELECTION_H_

#include <ostream>
#include <string>
#include <vector>

#include "core/pinhole.h"
#include "core/status.h"
#include "stages/scene/workspace_scene.h"

namespace freegs::stages {

// The views of all photos, sorted by name (NaturalLess), at the photographs'
// own size.
std::vector<View> PhotoViews(const WorkspaceScene& scene);

// Picks `count` of the views, evenly spread over the list and in its order.
// Returns all of them when there are not more.
std::vector<View> SpreadViews(const std::vector<View>& views, int count);

struct ViewSelection {
  // A camera file (stages/scene/camera_file.h); empty takes the photos' views.
  std::string cameras = {};

  // The poses of a camera file may be in another world frame. With `align` they
  // are mapped into the scene's frame by the similarity between the poses of
  // the photos that the file's "train" section and the workspace both name.
  // Without it they are in the workspace's world frame.
  bool align = true;

  // Only the views of "test" are taken from a file that has both sections.
  bool only_test = false;

  // Upper bounds of the longest side in pixels: the first holds for views of a
  // file, the second for the photos' views. 0 is no bound.
  int max_side = 0;
  int photo_max_side = 0;

  std::string command = {};  // The command's name, which begins messages.
};

// kBadInput for a view of more than 100 million pixels, whose picture would
// take gigabytes. The message ends with `advice`.
Status CheckViewSize(const View& view, const std::string& advice);

struct SelectedViews {
  std::vector<View> views;  // In the frame of the scene.

  // From there to the world in which the poses are given: that of the camera
  // file, or that of the workspace.
  Sim3d world_from_scene;
};

// The views of the file selection.cameras at their own size, however large.
// `messages` and the errors are those of ViewsToRender; kBadInput, too, when a
// view of "train" and one of "test" that are both taken have the same name.
StatusOr<SelectedViews> FileViews(const WorkspaceScene& scene,
                                  const ViewSelection& selection,
                                  std::ostream& messages);

// Returns the selected views. `messages` receives a line that says how well the
// poses of an aligned file agree with the scene's. kBadInput names the file and
// the fault; it is also the error for a view that is too large (CheckViewSize).
StatusOr<SelectedViews> ViewsToRender(const WorkspaceScene& scene,
                                      const ViewSelection& selection,
                                      std::ostream& messages);

// Whether a view has this name, or has it when its extension is ignored.
bool HasViewName(const View& view, const std::string& name);

// Finds the view with this name, or else the only view that has this name when
// extensions are ignored. kInvalidArgument when there is no such view (the
// message lists similar names) or when several match without extension.
StatusOr<View> FindView(const std::vector<View>& views,
                        const std::string& name);

}  // namespace freegs::stages

#endif  // FREEGS_STAGES_SCENE_VIEW_SELECTION_H_
