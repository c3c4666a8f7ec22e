// SPDX-License-Identifier: BSD-3-Clause

#include "stages/scene/instance_maps.h"

#include <algorithm>
#include <filesystem>
#include <string>
#include <system_error>

#include "core/io/files.h"
#include "core/io/image_io.h"
#include "splat/render/renderer.h"
#include "stages/scene/scene_instances.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;

Status WritePreview(const fs::path& photo_path,
                    const Image<int32_t>& map,
                    const fs::path& path) {
  FREEGS_ASSIGN_OR_RETURN(ImageU8 photo, ReadRgb(photo_path));
  if (photo.width() != map.width() || photo.height() != map.height()) {
    photo = Resize(photo, map.width(), map.height());
  }
  FREEGS_RETURN_IF_ERROR(CreateFolders(path.parent_path()));
  return WriteImage(path, OverlayInstances(photo, map));
}

}  // namespace

Status WriteInstanceMaps(int num_previews,
                         const WorkspaceScene& scene,
                         const std::vector<View>& views,
                         const std::vector<int32_t>& instance_of_gaussian,
                         pipeline::StageContext& context) {
  FREEGS_ASSIGN_OR_RETURN(const std::vector<std::string> names,
                          OutputNames(views, ".png"));
  const int64_t count = static_cast<int64_t>(views.size());
  const int64_t previews = std::min<int64_t>(num_previews, count);
  for (int64_t i = 0; i < count; ++i) {
    if (context.cancellation->cancelled()) {
      return InterruptedError(
          "bootstrap: stopped while drawing instance maps; those drawn are "
          "kept");
    }
    context.progress({"instance maps",
                      static_cast<double>(i),
                      static_cast<double>(count),
                      ""});
    const fs::path map_path = context.output / "instances" / names[i];
    const fs::path preview_path = context.output / "preview" / names[i];
    // The first view of each of so many equal parts.
    const bool preview = i * previews % count < previews;
    std::error_code error;
    if (context.resuming && fs::exists(map_path, error) &&
        (!preview || fs::exists(preview_path, error))) {
      continue;
    }
    const View& view = views[i];
    const Image<int32_t> map = splat::RenderLabels(scene.model,
                                                   view.camera,
                                                   view.cam_from_world,
                                                   scene.render,
                                                   *context.pool,
                                                   instance_of_gaussian);
    if (preview) {
      FREEGS_RETURN_IF_ERROR(
          WritePreview(context.workspace / "undistort" / "images" / view.name,
                       map,
                       preview_path));
    }
    FREEGS_RETURN_IF_ERROR(CreateFolders(map_path.parent_path()));
    FREEGS_RETURN_IF_ERROR(WriteLabels(map_path, EncodeInstances(map)));
  }
  return {};
}

}  // namespace freegs::stages
