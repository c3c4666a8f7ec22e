// SPDX-License-Identifier: BSD-3-Clause

#include "stages/scene/instance_maps.h"

#include <algorithm>
#include <filesystem>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "core/cancellation.h"
#include "core/io/files.h"
#include "core/io/image_io.h"
#include "semantics/geometry/view_loop.h"
#include "splat/render/rasterizer.h"
#include "splat/render/renderer.h"
#include "stages/scene/scene_instances.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;

// The instances that a view shows, and where they go.
struct DrawnMap {
  fs::path path;
  // For a view with a preview: the photograph under it, and its own file.
  fs::path photo_path;
  fs::path preview_path;
  Image<int32_t> map;
};

bool IsWritten(const DrawnMap& drawn) {
  std::error_code error;
  return fs::exists(drawn.path, error) &&
         (drawn.preview_path.empty() || fs::exists(drawn.preview_path, error));
}

Status WritePreview(const DrawnMap& drawn) {
  const Image<int32_t>& map = drawn.map;
  FREEGS_ASSIGN_OR_RETURN(ImageU8 photo, ReadRgb(drawn.photo_path));
  if (photo.width() != map.width() || photo.height() != map.height()) {
    photo = Resize(photo, map.width(), map.height());
  }
  FREEGS_RETURN_IF_ERROR(CreateFolders(drawn.preview_path.parent_path()));
  return WriteImage(drawn.preview_path, OverlayInstances(photo, map));
}

Status Write(const DrawnMap& drawn) {
  if (!drawn.preview_path.empty()) FREEGS_RETURN_IF_ERROR(WritePreview(drawn));
  FREEGS_RETURN_IF_ERROR(CreateFolders(drawn.path.parent_path()));
  return WriteLabels(drawn.path, EncodeInstances(drawn.map));
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
  splat::Rasterizer rasterizer;
  // The maps that wait for being written.
  std::vector<DrawnMap> drawn;
  for (int64_t i = 0; i < count; ++i) {
    if (IsCancelled(context.cancellation)) {
      return InterruptedError(
          "stopped while drawing instance maps; those written are kept");
    }
    context.progress({"instance maps",
                      static_cast<double>(i),
                      static_cast<double>(count),
                      ""});
    const View& view = views[i];
    DrawnMap next;
    next.path = context.output / "instances" / names[i];
    // The first view of each of so many equal parts.
    if (i * previews % count < previews) {
      next.photo_path = context.workspace / "undistort" / "images" / view.name;
      next.preview_path = context.output / "preview" / names[i];
    }
    if (!(context.resuming && IsWritten(next))) {
      next.map = rasterizer.Labels(scene.model,
                                   view.camera,
                                   view.cam_from_world,
                                   scene.render,
                                   instance_of_gaussian,
                                   splat::kMinLabelWeight,
                                   *context.pool);
      drawn.push_back(std::move(next));
    }
    // One view is drawn by all threads. Writing takes one thread, so as many
    // maps are written at once as there are threads.
    if (i + 1 == count ||
        drawn.size() == static_cast<size_t>(context.pool->num_threads())) {
      FREEGS_RETURN_IF_ERROR(semantics::ForEachView(
          "writing instance maps",
          drawn.size(),
          *context.pool,
          nullptr,
          [](size_t) {},
          [&](size_t k) { return Write(drawn[k]); }));
      drawn.clear();
    }
  }
  return {};
}

}  // namespace freegs::stages
