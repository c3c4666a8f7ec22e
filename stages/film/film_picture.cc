// SPDX-License-Identifier: BSD-3-Clause

#include "stages/film/film_picture.h"

#include <algorithm>

#include "core/io/image_io.h"
#include "splat/render/renderer.h"
#include "stages/scene/scene_instances.h"

namespace freegs::stages {
namespace {

// Both pictures have the same size.
ImageU8 SideBySide(const ImageU8& left, const ImageU8& right) {
  ImageU8 joined(left.width() + right.width(), left.height(), 3);
  for (int y = 0; y < left.height(); ++y) {
    std::copy_n(left.row(y), 3 * left.width(), joined.row(y));
    std::copy_n(
        right.row(y), 3 * right.width(), joined.row(y) + 3 * left.width());
  }
  return joined;
}

}  // namespace

ImageU8 FilmPicture(const WorkspaceScene& scene,
                    const FilmContent& content,
                    const View& view,
                    ThreadPool& pool) {
  const auto instances = [&] {
    return ColorInstances(RenderLabels(scene, view, content.labels, pool));
  };
  if (content.what == "instances") return instances();
  splat::FeatureChannels features;
  if (content.what == "semantics") {
    features = {.values = content.semantic_colors, .channels = 3};
  }
  const splat::RenderedView rendered = splat::RenderView(scene.model,
                                                         view.camera,
                                                         view.cam_from_world,
                                                         scene.render,
                                                         pool,
                                                         features);
  if (content.what == "semantics") return ToU8(rendered.features);
  if (content.what == "depth") {
    return ColorDepth(rendered.depth, content.depth_range);
  }
  const ImageU8 color = ToU8(rendered.color);
  return content.what == "both" ? SideBySide(color, instances()) : color;
}

}  // namespace freegs::stages
