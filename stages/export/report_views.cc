// SPDX-License-Identifier: BSD-3-Clause

#include "stages/export/report_views.h"

#include <algorithm>
#include <cstdlib>
#include <utility>

#include "core/io/image_io.h"
#include "splat/render/renderer.h"
#include "stages/scene/exposure_file.h"
#include "stages/scene/scene_instances.h"

namespace freegs::stages {
namespace {

namespace fs = std::filesystem;

// 4 x the mean absolute difference of the channels, as grey. Both pictures are
// H x W x 3 and of the same size.
ImageU8 DifferenceImage(const ImageU8& a, const ImageU8& b) {
  ImageU8 difference(a.width(), a.height(), 1);
  for (size_t k = 0; k < difference.size(); ++k) {
    int sum = 0;
    for (size_t c = 0; c < 3; ++c) {
      sum += std::abs(a.data()[3 * k + c] - b.data()[3 * k + c]);
    }
    difference.data()[k] = static_cast<uint8_t>(std::min(255, 4 * sum / 3));
  }
  return difference;
}

}  // namespace

StatusOr<ReportView> WriteReportView(const WorkspaceScene& scene,
                                     const View& view,
                                     const DepthRange& depth_range,
                                     std::span<const int32_t> labels,
                                     const fs::path& photo_path,
                                     const fs::path& folder,
                                     const std::string& prefix,
                                     ThreadPool& pool) {
  ReportView result;
  result.name = view.name;
  const auto write = [&](const std::string& what,
                         const ImageU8& image,
                         std::string* path) -> Status {
    const std::string file = prefix + "_" + what + ".jpg";
    *path = (folder.filename() / file).generic_string();
    return WriteImage(folder / file, image);
  };

  const Pinhole camera = view.camera.LimitedTo(scene.training_max_side);
  splat::RenderedView rendered = splat::RenderView(
      scene.model, camera, view.cam_from_world, scene.render, pool);
  const ImageU8 render = ToU8(InExposureOf(
      view.name, scene.exposures, std::move(rendered.color), pool));
  FREEGS_RETURN_IF_ERROR(write("render", render, &result.render));
  FREEGS_RETURN_IF_ERROR(
      write("depth", ColorDepth(rendered.depth, depth_range), &result.depth));

  // Instances are drawn over the photo, or over the rendering without a photo.
  ImageU8 ground = render;
  const StatusOr<ImageU8> photo = ReadRgb(photo_path);
  if (photo.ok()) {
    ground = Resize(*photo, camera.width, camera.height);
    FREEGS_RETURN_IF_ERROR(write("photo", ground, &result.photo));
    FREEGS_RETURN_IF_ERROR(write(
        "difference", DifferenceImage(ground, render), &result.difference));
  }
  if (!labels.empty()) {
    const Image<int32_t> map = splat::RenderLabels(
        scene.model, camera, view.cam_from_world, scene.render, pool, labels);
    FREEGS_RETURN_IF_ERROR(
        write("instances", OverlayInstances(ground, map), &result.instances));
  }
  return result;
}

}  // namespace freegs::stages
