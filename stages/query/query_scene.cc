// SPDX-License-Identifier: BSD-3-Clause

#include "stages/query/query_scene.h"

#include <algorithm>
#include <filesystem>
#include <sstream>
#include <string>
#include <system_error>
#include <utility>

#include "semantics/instances/instances_json.h"
#include "stages/scene/scene_instances.h"
#include "stages/scene/view_selection.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;

// The path of a file that stage bootstrap writes.
StatusOr<fs::path> BootstrapFile(const QueryRequest& request,
                                 const std::string& name,
                                 const std::string& advice) {
  const fs::path path = request.workspace / "bootstrap" / name;
  std::error_code error;
  if (!fs::exists(path, error)) {
    return BadInputError(path.string() + ": no such file; " + advice);
  }
  return path;
}

// One flag per instance id that the features or the labels contain.
std::vector<uint8_t> BackgroundFlags(const QueryScene& scene) {
  size_t count = scene.features ? scene.features->size() : 0;
  for (const int32_t label : scene.labels) {
    count = std::max(count, static_cast<size_t>(label + 1));
  }
  std::vector<uint8_t> flags(count);
  for (const semantics::Instance& instance : scene.instances) {
    const auto place = static_cast<size_t>(instance.id) - 1;
    if (place < count) flags[place] = instance.background;
  }
  return flags;
}

Status LoadFeatures(const QueryRequest& request, QueryScene* scene) {
  FREEGS_ASSIGN_OR_RETURN(
      const fs::path path,
      BootstrapFile(request,
                    "instance_features.json",
                    "the scene knows its instances but not what they are, so "
                    "that only --click and --box can be answered; run stage "
                    "bootstrap again with --bootstrap.mode lift"));
  FREEGS_RETURN_IF_ERROR(CheckBootstrapOfModel(request.workspace));
  FREEGS_ASSIGN_OR_RETURN(scene->features,
                          semantics::ReadInstanceFeatures(path));
  std::vector<uint8_t> listed(scene->features->size());
  for (const semantics::Instance& instance : scene->instances) {
    if (static_cast<size_t>(instance.id) > listed.size()) {
      return BadInputError(path.string() + ": has no instance " +
                           std::to_string(instance.id) +
                           " of instances.json; run stage bootstrap again");
    }
    listed[static_cast<size_t>(instance.id) - 1] = 1;
  }
  for (size_t i = 0; i < listed.size(); ++i) {
    if (listed[i] == 0 && scene->features->known(i)) {
      return BadInputError(path.string() + ": has an instance " +
                           std::to_string(i + 1) +
                           " that instances.json has not; run stage bootstrap "
                           "again");
    }
  }
  return Status();
}

Status LoadViews(const QueryRequest& request,
                 std::ostream& messages,
                 QueryScene* scene) {
  FREEGS_ASSIGN_OR_RETURN(WorkspaceScene read,
                          ReadWorkspaceScene(request.workspace));
  FREEGS_ASSIGN_OR_RETURN(
      std::vector<int32_t> labels,
      ReadInstanceLabels(request.workspace, read.model.size()));
  const ViewSelection selection{.cameras = request.cameras,
                                .align = !request.no_align,
                                .max_side = request.size,
                                .photo_max_side = request.size,
                                .command = "query"};
  FREEGS_ASSIGN_OR_RETURN(SelectedViews selected,
                          ViewsToRender(read, selection, messages));
  std::vector<View> views = std::move(selected.views);
  std::vector<View> photos = PhotoViews(read);
  std::vector<View> file_views;
  if ((request.click || request.box) && !request.cameras.empty()) {
    // Pixels are those of the cameras, whatever the size of the masks. For a
    // click only one is rendered, for a box all of them.
    std::ostringstream ignored;  // The first call has printed the messages.
    FREEGS_ASSIGN_OR_RETURN(selected, FileViews(read, selection, ignored));
    file_views = std::move(selected.views);
    for (const View& view : file_views) {
      if (!request.box) break;
      FREEGS_RETURN_IF_ERROR(
          CheckViewSize(view,
                        "that is too large for --box; click, or give cameras "
                        "of smaller pictures")
              .Annotated(selection.command));
    }
  }
  // All at once: if memory had run out before, nothing would be missing of a
  // scene that looks loaded.
  scene->scene = std::move(read);
  scene->labels = std::move(labels);
  scene->views = std::move(views);
  scene->photos = std::move(photos);
  scene->file_views = std::move(file_views);
  return Status();
}

}  // namespace

Status LoadQueryScene(const QueryRequest& request,
                      std::ostream& messages,
                      QueryScene* scene) {
  FREEGS_ASSIGN_OR_RETURN(
      const fs::path path,
      BootstrapFile(request, "instances.json", "run stage bootstrap first"));
  if (scene->instances.empty()) {
    FREEGS_ASSIGN_OR_RETURN(scene->instances, semantics::ReadInstances(path));
  }
  if ((request.text || request.example) && !scene->features) {
    FREEGS_RETURN_IF_ERROR(LoadFeatures(request, scene));
  }
  if ((request.click || request.box || !request.out.empty()) && !scene->scene) {
    FREEGS_RETURN_IF_ERROR(LoadViews(request, messages, scene));
    FREEGS_RETURN_IF_ERROR(
        CheckInstanceIds(scene->instances, scene->labels.size(), path));
  }
  scene->is_background = BackgroundFlags(*scene);
  return Status();
}

}  // namespace freegs::stages
