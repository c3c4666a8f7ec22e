// SPDX-License-Identifier: BSD-3-Clause

#include "stages/scene/view_selection.h"

#include <algorithm>
#include <cstdint>
#include <set>
#include <utility>

#include "core/number_text.h"
#include "core/text.h"
#include "pipeline/option_value.h"
#include "stages/scene/camera_file.h"
#include "stages/scene/scene_alignment.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;

// A larger picture would take gigabytes; it is more likely a mistake in a
// camera file.
constexpr int64_t kMaxPixels = 100'000'000;

// So many names are listed in an error message.
constexpr size_t kMaxNames = 5;

std::string Stem(const std::string& name) {
  return fs::path(name).replace_extension().string();
}

// Names to suggest for `name`: the one with the most similar spelling first,
// then its neighbours in the alphabet.
std::string NamesLike(const std::vector<View>& views, const std::string& name) {
  std::vector<std::string> names;
  for (const View& view : views) names.push_back(view.name);
  std::sort(names.begin(), names.end());
  names.erase(std::unique(names.begin(), names.end()), names.end());
  const std::string nearest = pipeline::NearestName(name, names);
  const auto place =
      std::lower_bound(names.begin(), names.end(), name) - names.begin();
  const auto first = static_cast<size_t>(std::clamp<int64_t>(
      place - static_cast<int64_t>(kMaxNames / 2),
      0,
      std::max<int64_t>(0,
                        static_cast<int64_t>(names.size()) -
                            static_cast<int64_t>(kMaxNames))));
  std::string list = nearest;
  for (size_t i = first; i < std::min(first + kMaxNames, names.size()); ++i) {
    if (names[i] == nearest) continue;
    list += (list.empty() ? "" : ", ") + names[i];
  }
  return list;
}

// kBadInput when two views have the same name.
Status CheckNames(const std::vector<View>& views) {
  std::set<std::string> known;
  for (const View& view : views) {
    if (known.insert(view.name).second) continue;
    return BadInputError("view \"" + view.name +
                         "\": is in \"train\" and in \"test\"; give each view "
                         "a name of its own");
  }
  return Status();
}

}  // namespace

std::vector<View> PhotoViews(const WorkspaceScene& scene) {
  std::vector<View> views = scene.train;
  views.insert(views.end(), scene.holdout.begin(), scene.holdout.end());
  std::ranges::sort(views, NaturalLess, &View::name);
  return views;
}

std::vector<View> SpreadViews(const std::vector<View>& views, int count) {
  const size_t wanted =
      std::min(views.size(), static_cast<size_t>(std::max(0, count)));
  std::vector<View> chosen;
  for (size_t i = 0; i < wanted; ++i) {
    chosen.push_back(views[i * views.size() / wanted]);
  }
  return chosen;
}

Status CheckViewSize(const View& view, const std::string& advice) {
  if (int64_t{view.camera.width} * view.camera.height <= kMaxPixels) {
    return Status();
  }
  return BadInputError(
      "view " + view.name + " is " + std::to_string(view.camera.width) + " x " +
      std::to_string(view.camera.height) + " pixels; " + advice);
}

StatusOr<SelectedViews> FileViews(const WorkspaceScene& scene,
                                  const ViewSelection& selection,
                                  std::ostream& messages) {
  FREEGS_ASSIGN_OR_RETURN(const CameraSet cameras,
                          ReadCameraSet(selection.cameras));
  std::vector<View> views = cameras.train;
  if (selection.only_test && !cameras.test.empty()) views.clear();
  views.insert(views.end(), cameras.test.begin(), cameras.test.end());
  FREEGS_RETURN_IF_ERROR(CheckNames(views).Annotated(selection.cameras));
  if (!selection.align) {
    const Sim3d world_from_scene = scene.frame.WorldFromFrame();
    return SelectedViews{MapViews(views, world_from_scene), world_from_scene};
  }

  const StatusOr<sfm::PoseAlignment> alignment =
      AlignWithViews(scene, cameras.train, selection.cameras);
  if (!alignment.ok()) {
    return BadInputError(
        selection.cameras +
        ": cannot be aligned with the scene: " + alignment.status().message() +
        "; its \"train\" section must name photos of the workspace. If its "
        "poses are in the scene's own frame, give --no-align");
  }
  messages << selection.command << ": aligned by "
           << alignment->residuals.size()
           << " photos, rotation residual median "
           << FormatFixed(alignment->median_rotation_deg, 3) << " deg\n";
  return SelectedViews{MapViews(views, alignment->target_from_source),
                       alignment->target_from_source};
}

StatusOr<SelectedViews> ViewsToRender(const WorkspaceScene& scene,
                                      const ViewSelection& selection,
                                      std::ostream& messages) {
  SelectedViews selected;
  int max_side = selection.max_side;
  if (!selection.cameras.empty()) {
    FREEGS_ASSIGN_OR_RETURN(selected, FileViews(scene, selection, messages));
  } else {
    selected = {PhotoViews(scene), scene.frame.WorldFromFrame()};
    max_side = selection.photo_max_side;
  }
  for (View& view : selected.views) {
    view.camera = view.camera.LimitedTo(max_side);
    FREEGS_RETURN_IF_ERROR(CheckViewSize(view, "limit it with --size")
                               .Annotated(selection.command));
  }
  return selected;
}

bool HasViewName(const View& view, const std::string& name) {
  return view.name == name || Stem(view.name) == name;
}

StatusOr<View> FindView(const std::vector<View>& views,
                        const std::string& name) {
  const View* found = nullptr;
  int num_stems = 0;
  for (const View& view : views) {
    if (view.name == name) return view;
    if (HasViewName(view, name)) {
      found = &view;
      ++num_stems;
    }
  }
  if (num_stems == 1) return *found;
  if (num_stems > 1) {
    return InvalidArgumentError("view \"" + name +
                                "\": several have this name; give the "
                                "extension too");
  }
  return InvalidArgumentError(
      "view \"" + name + "\": there is no such view of " +
      std::to_string(views.size()) +
      (views.empty() ? "" : "; there are " + NamesLike(views, name)));
}

}  // namespace freegs::stages
